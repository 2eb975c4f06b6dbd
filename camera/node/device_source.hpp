#pragma once

#include <memory>

#include "camera/devices/device_options.hpp"
#include "camera/node/camera_node.hpp"

namespace multireach {

/// Reads two cameras, or one that gives both images, each in its own thread, and pairs their frames by time of capture.
/// The source ends when a video file ends; it waits for any other device that disappears. Throws InputError when a
/// device cannot be opened at the start, or does not give the requested size or format.
std::unique_ptr<CameraSource> make_device_source(const DeviceOptions& options);

}  // namespace multireach
