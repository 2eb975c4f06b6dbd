#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/foxglove/scene.hpp"

namespace multireach {

/// Exports a log to third-party formats. Messages of unknown types are skipped. All functions return the number of
/// messages written, throw InputError when a log cannot be read, and throw as OutputFile does.

/// Selects channels by shell patterns, e.g. "JOINT_*"; an empty list selects all.
using ChannelPatterns = std::vector<std::string>;
bool matches_any(const ChannelPatterns& patterns, std::string_view channel);
/// Makes a channel's name safe for a file or variable: anything but letters, digits, '-' and '_' becomes '_'.
std::string safe_file_name(std::string_view name);

/// Writes a folder with one table per channel, CHANNEL.csv: a row for each message, a column for each number or string.
/// Arrays have a column for each element; byte arrays are skipped.
int64_t export_csv(const std::string& log, const std::string& folder, const ChannelPatterns& patterns);
/// Writes a MATLAB file (version 5) with a struct for each channel, whose fields have a row for each message; strings
/// are taken from the first message. Holds the numbers of one channel in memory at a time.
int64_t export_mat(const std::string& log, const std::string& file, const ChannelPatterns& patterns);
/// Writes an MCAP file with JSON messages and their schemas; images as foxglove.CompressedImage or foxglove.RawImage on
/// CHANNEL/left and CHANNEL/right; with `scene` also what it draws. The count includes these.
int64_t export_mcap(const std::string& log, const std::string& file, const ChannelPatterns& patterns,
                    FoxgloveScene* scene = nullptr);
/// Writes the images as PNG files, NUMBER_left.png and NUMBER_right.png, numbered from 0. Images that cannot be decoded
/// are listed in `warnings`.
int64_t export_images(const std::string& log, const std::string& folder, const ChannelPatterns& patterns,
                      std::vector<std::string>& warnings);

// A session's pairs as recordings that multireach-log import reads: images at their own times. What is left out is
// listed in `warnings`. The functions throw InputError also for an image that cannot be decoded.

/// Writes a folder with pairs.csv and the image files in left/ and right/: JPEG data as they are, others as PNG.
int64_t export_pairs(const std::string& log, const std::string& folder, std::vector<std::string>& warnings);
/// Writes a folder as that of an EuRoC recording: mav0/cam0 and mav0/cam1, with PNG files.
int64_t export_euroc(const std::string& log, const std::string& folder, std::vector<std::string>& warnings);
/// Writes a bag of ROS 1 with sensor_msgs/CompressedImage on /left/image_raw/compressed and
/// /right/image_raw/compressed.
int64_t export_bag(const std::string& log, const std::string& file, std::vector<std::string>& warnings);

}  // namespace multireach
