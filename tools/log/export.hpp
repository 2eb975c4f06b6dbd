#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace multireach {

/// A log in the formats of other tools. Messages of types that are not the project's are left out. All return how many
/// messages were written, and throw InputError when a log cannot be read or a file not written.

/// Which channels: shell patterns, as "JOINT_*"; all where there is none.
using ChannelPatterns = std::vector<std::string>;
bool chosen(const ChannelPatterns& patterns, std::string_view channel);
/// A channel's name as a file or a variable may be called: what is no letter, digit, '-' or '_' becomes '_'.
std::string harmless(std::string_view name);

/// A folder with a table for every channel, CHANNEL.csv: a row for each message, a column for each number or string.
/// Arrays have a column for each element; byte arrays are left out.
int64_t export_csv(const std::string& log, const std::string& folder, const ChannelPatterns& patterns);
/// A MATLAB file (version 5) with a struct for every channel, whose fields have a row for each message; strings are
/// those of the first message. Takes memory for the numbers of one channel at a time.
int64_t export_mat(const std::string& log, const std::string& file, const ChannelPatterns& patterns);
/// An MCAP file with JSON messages and their schemas; images as foxglove.CompressedImage or foxglove.RawImage on
/// CHANNEL/left and CHANNEL/right.
int64_t export_mcap(const std::string& log, const std::string& file, const ChannelPatterns& patterns);
/// A folder with the images as PNG files, NUMBER_left.png and NUMBER_right.png, numbered from 0. Those that cannot be
/// decoded are said in `complaints`.
int64_t export_images(const std::string& log, const std::string& folder, const ChannelPatterns& patterns,
                      std::vector<std::string>& complaints);

}  // namespace multireach
