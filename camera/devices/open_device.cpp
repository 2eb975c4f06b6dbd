#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "camera/devices/camera_device.hpp"
#include "camera/devices/stream_device.hpp"
#include "camera/devices/v4l2_device.hpp"
#include "camera/devices/video_file_device.hpp"

namespace multireach {

OpenedDevice open_device(const std::string& name, const DeviceRequest& request) {
  const bool number = !name.empty() && std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
  const std::string path = number ? "/dev/video" + name : name;
  struct stat status = {};
  if (stat(path.c_str(), &status) != 0) {
    return {.device = nullptr,
            .fault = "'" + name + "': is neither a camera device nor a video that can be opened (" + path + ": " +
                     std::strerror(errno) + ")",
            .absent = true};
  }
  if (S_ISCHR(status.st_mode)) return open_v4l2(kernel_calls(), path, request);
  if (S_ISFIFO(status.st_mode)) return open_stream(path);
  if (S_ISREG(status.st_mode)) return open_video_file(path, request);
  return {.device = nullptr, .fault = "'" + name + "': is neither a camera device nor a video nor a FIFO"};
}

}  // namespace multireach
