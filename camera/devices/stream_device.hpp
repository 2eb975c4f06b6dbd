#pragma once

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// JPEG images that another program writes into a FIFO, one after the other or inside of AVI or multipart; stamped when
/// they have arrived. A writer that closes its end is a camera that was unplugged.
OpenedDevice open_stream(const std::string& path);

}  // namespace multireach
