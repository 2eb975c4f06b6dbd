#pragma once

#include <optional>
#include <string_view>

#include "tools/log/import/byte_reader.hpp"
#include "tools/log/import/image_store.hpp"

namespace multireach {

/// How a message's fields are laid out.
enum class RosEncoding { kRos1, kCdr };

/// sensor_msgs/Image or sensor_msgs/CompressedImage of ROS 1 or ROS 2.
enum class RosType { kImage, kCompressedImage };

/// "sensor_msgs/Image", "sensor_msgs/msg/CompressedImage" and the like; nothing for other types.
std::optional<RosType> ros_image_type(std::string_view name);

/// The time stamp of the message's header, microseconds. Throws InputError when the message is too short.
int64_t ros_stamp(ByteReader message, RosEncoding encoding);

/// The image of a message. Throws InputError when the message is damaged, or its pixel format is not supported.
Frame ros_frame(ByteReader message, RosEncoding encoding, RosType type, ImageStore& store);

}  // namespace multireach
