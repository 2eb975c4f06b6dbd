#pragma once

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// Reads JPEG images that another program writes into a FIFO, one after the other or inside AVI or multipart; they are
/// stamped on arrival. When the writer closes its end, that is handled like an unplugged camera.
OpenedDevice open_stream(const std::string& path);

}  // namespace multireach
