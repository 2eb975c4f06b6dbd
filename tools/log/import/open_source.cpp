#include <filesystem>
#include <string_view>

#include "runtime/mapped_file.hpp"
#include "tools/log/import/ros_recording.hpp"

namespace multireach {

std::unique_ptr<ImageSource> open_image_source(const ImportOptions& options) {
  const std::string& input = options.input;
  std::error_code error;
  const auto holds = [&](const char* name) { return std::filesystem::exists(input + "/" + name, error); };
  if (std::filesystem::is_directory(input, error)) {
    if (holds("pairs.csv")) return open_pairs_folder(options);
    if (holds("mav0") || holds("cam0")) return open_euroc_folder(options);
    if (holds("metadata.yaml")) throw InputError(input + ": is a folder of ROS 2; expected the .mcap file in it");
    throw InputError(input +
                     ": is not a folder that can be imported; expected pairs.csv in it, or mav0/cam0 or cam0 as in "
                     "the EuRoC dataset");
  }
  const MappedFile file(input);
  const std::string_view begin(reinterpret_cast<const char*>(file.bytes().data()),
                               std::min<size_t>(file.bytes().size(), 16));
  if (begin.starts_with("#ROSBAG V2.0\n")) return open_bag(options);
  if (begin.starts_with("\x89MCAP0\r\n")) return open_mcap(options);
  if (begin.starts_with("SQLite format 3"))
    throw InputError(input +
                     ": is a recording of ROS 2 in SQLite; expected MCAP, which `ros2 bag convert` makes of it");
  throw InputError(input +
                   ": byte 0: is not a recording that can be imported; expected a bag of ROS 1 (#ROSBAG V2.0), an "
                   "MCAP file, or a folder with pairs.csv or of EuRoC");
}

}  // namespace multireach
