#pragma once

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// Plays a video file at the requested rate from `request.start_us`: image k is stamped k periods later, however late
/// it is read. So two files of the same rate always give the same pairs.
OpenedDevice open_video_file(const std::string& path, const DeviceRequest& request);

}  // namespace multireach
