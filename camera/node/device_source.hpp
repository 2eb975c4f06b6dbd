#pragma once

#include <memory>

#include "camera/devices/device_options.hpp"
#include "camera/node/camera_node.hpp"

namespace multireach {

/// Two cameras, or one that gives both images, each grabbed by a thread of its own; their frames paired by the time of
/// capture. A video file that ends is the end; any other device that is gone is waited for. Throws InputError when a
/// device cannot be opened at the start, or does not give the size or format asked for.
std::unique_ptr<CameraSource> make_device_source(const DeviceOptions& options);

}  // namespace multireach
