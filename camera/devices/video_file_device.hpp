#pragma once

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// A video file, played at the rate asked for from `request.start_us`: image k counts as captured k periods later,
/// however late it is read. So two files of the same rate give the same pairs every time.
OpenedDevice open_video_file(const std::string& path, const DeviceRequest& request);

}  // namespace multireach
