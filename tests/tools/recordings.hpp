#pragma once

// Recordings whose bytes are laid out here by hand, from the descriptions of their formats.
#include <bzlib.h>
#include <gtest/gtest.h>
#include <lodepng.h>
#include <lz4frame.h>
#include <zstd.h>

#include <cstdlib>
#include <filesystem>
#include <multireach/images_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "tests/input_fault.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/log/import/import.hpp"
#include "tools/replay/session.hpp"

namespace multireach {

inline const std::string kSession = MULTIREACH_SOURCE_DIR "/logs/reach.lcm";
inline constexpr size_t kPairs = 20;

inline std::string little(uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text.push_back(i < 8 ? static_cast<char>(value >> 8 * i) : char{0});
  return text;
}
inline std::string sized(const std::string& bytes) {
  return little(bytes.size(), 4) + bytes;
}

inline std::string lz4_of(const std::string& bytes) {
  std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
  return out;
}
inline std::string zstd_of(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  return out;
}
inline std::string bz2_of(const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 50 + 600, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()), static_cast<unsigned>(bytes.size()), 9,
                           0, 0);
  out.resize(size);
  return out;
}
inline std::string compressed(const std::string& with, const std::string& bytes) {
  return with == "lz4" ? lz4_of(bytes) : with == "zstd" ? zstd_of(bytes) : with == "bz2" ? bz2_of(bytes) : bytes;
}

/// Makes recordings of the first pairs of a bundled session, and imports them.
class LogImport : public ::testing::Test {
 protected:
  LogImport() {
    LogReader log(kSession);
    while (const auto event = log.next()) {
      if (event->channel != channel::kStereoImages || pairs_.size() == kPairs) continue;
      pairs_.push_back(*decode<images_t>(event->data));
    }
    options_.left = "/left";
    options_.right = "/right";
  }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string written(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    write_text_file(path(name), bytes);
    return path(name);
  }
  ImportSummary import(const std::string& input) {
    options_.input = input;
    return import_images(options_, path("session.lcm"), [](double) {});
  }
  std::string import_fault(const std::string& input) {
    return testing::input_fault([&] { import(input); });
  }
  std::vector<images_t> session() const {
    std::vector<images_t> pairs;
    LogReader log(path("session.lcm"));
    while (const auto event = log.next()) {
      EXPECT_EQ(event->channel, channel::kStereoImages);
      pairs.push_back(*decode<images_t>(event->data));
      EXPECT_EQ(event->utime, pairs.back().utime);
    }
    return pairs;
  }
  /// The imported session has the very messages of the recorded one.
  void expect_the_same_pairs() const {
    const std::vector<images_t> imported = session();
    ASSERT_EQ(imported.size(), pairs_.size());
    for (size_t i = 0; i < imported.size(); ++i) EXPECT_EQ(encode(imported[i]), encode(pairs_[i])) << i;
    EXPECT_EQ(replay_source(path("session.lcm")), ReplayFrom::kImages);
  }
  static std::string data_of(const image_t& image) { return {image.data.begin(), image.data.end()}; }

  // ROS messages.
  static std::string ros1_header(int64_t utime) {
    return little(7, 4) + little(static_cast<uint64_t>(utime / 1000000), 4) +
           little(static_cast<uint64_t>(utime % 1000000 * 1000), 4) + sized("camera");
  }
  static std::string ros1_compressed(const image_t& image) {
    return ros1_header(image.utime) + sized("jpeg") + sized(data_of(image));
  }
  static std::string ros1_raw(int64_t utime, uint32_t width, uint32_t height, const std::string& encoding,
                              uint32_t step, const std::string& data) {
    return ros1_header(utime) + little(height, 4) + little(width, 4) + sized(encoding) + little(0, 1) +
           little(step, 4) + sized(data);
  }
  /// CDR: strings end in a zero, and 32-bit numbers begin at multiples of four after the four bytes of the header.
  static std::string cdr_text(const std::string& text) {
    std::string bytes = little(text.size() + 1, 4) + text + '\0';
    while (bytes.size() % 4 != 0) bytes += '\0';
    return bytes;
  }
  static std::string cdr_header(int64_t utime) {
    return std::string("\0\1\0\0", 4) + little(static_cast<uint64_t>(utime / 1000000), 4) +
           little(static_cast<uint64_t>(utime % 1000000 * 1000), 4) + cdr_text("camera_frame");
  }
  static std::string cdr_compressed(const image_t& image) {
    return cdr_header(image.utime) + cdr_text("jpeg") + sized(data_of(image));
  }

  // MCAP.
  static std::string record(int type, const std::string& content) {
    return little(static_cast<uint64_t>(type), 1) + little(content.size(), 8) + content;
  }
  static std::string schema(int id, const std::string& name) {
    return record(3, little(static_cast<uint64_t>(id), 2) + sized(name) + sized("ros2msg") + sized("# text"));
  }
  static std::string channel_record(int id, int schema, const std::string& topic, const std::string& encoding = "cdr") {
    return record(4, little(static_cast<uint64_t>(id), 2) + little(static_cast<uint64_t>(schema), 2) + sized(topic) +
                         sized(encoding) + sized(""));
  }
  static std::string message_record(int channel, int64_t utime, const std::string& data) {
    const std::string ns = little(static_cast<uint64_t>(utime) * 1000, 8);
    return record(5, little(static_cast<uint64_t>(channel), 2) + little(0, 4) + ns + ns + data);
  }
  static std::string chunk_record(const std::string& records, const std::string& compression, bool with_crc = true) {
    const uint32_t crc =
        with_crc ? lodepng_crc32(reinterpret_cast<const unsigned char*>(records.data()), records.size()) : 0;
    const std::string data = compressed(compression, records);
    return record(6, little(0, 16) + little(records.size(), 8) + little(crc, 4) + sized(compression) +
                         little(data.size(), 8) + data);
  }
  static std::string mcap(const std::string& records) {
    const std::string magic("\x89MCAP0\r\n", 8);
    return magic + record(1, sized("ros2") + sized("test")) + records + record(15, little(0, 4)) +
           record(2, little(0, 20)) + magic;
  }
  static std::string declarations() {
    return schema(1, "sensor_msgs/msg/CompressedImage") + schema(2, "std_msgs/msg/String") +
           channel_record(5, 1, "/left") + channel_record(6, 1, "/right") + channel_record(7, 2, "/words");
  }
  /// The pairs in chunks of some messages; images of the right camera come first and late.
  std::string recorded_mcap(const std::string& compression) const {
    std::string chunks, records = declarations();
    for (size_t i = 0; i < pairs_.size(); ++i) {
      const image_t& left = pairs_[i].images[0];
      const image_t& right = pairs_[i].images[1];
      records += message_record(7, left.utime, "anything") + message_record(6, right.utime, cdr_compressed(right)) +
                 message_record(5, left.utime, cdr_compressed(left));
      if (i % 3 == 2 || i + 1 == pairs_.size()) {
        chunks += chunk_record(records, compression, i % 2 == 0);
        records = i == 2 ? declarations() : "";
      }
    }
    return mcap(chunks + record(8, "an index, which is not read"));
  }

  // Bags.
  static std::string field(const std::string& name, const std::string& value) { return sized(name + "=" + value); }
  static std::string bag_record(const std::string& header, const std::string& data) {
    return sized(header) + sized(data);
  }
  static std::string connection(uint32_t id, const std::string& topic, const std::string& type) {
    return bag_record(field("op", little(7, 1)) + field("conn", little(id, 4)) + field("topic", topic),
                      field("topic", topic) + field("type", type) +
                          field("md5sum", "8f7a12909da2c9d3332d540a0977563f") + field("message_definition", "# text"));
  }
  static std::string bag_message(uint32_t id, int64_t utime, const std::string& data) {
    return bag_record(field("op", little(2, 1)) + field("conn", little(id, 4)) +
                          field("time", little(static_cast<uint64_t>(utime / 1000000), 4) + little(0, 4)),
                      data);
  }
  static std::string bag_chunk(const std::string& records, const std::string& compression) {
    return bag_record(
        field("op", little(5, 1)) + field("compression", compression) + field("size", little(records.size(), 4)),
        compressed(compression, records));
  }
  static std::string bag(const std::string& records) {
    const std::string header = field("op", little(3, 1)) + field("index_pos", little(0, 8)) +
                               field("conn_count", little(3, 4)) + field("chunk_count", little(1, 4));
    return "#ROSBAG V2.0\n" + bag_record(header, std::string(4096 - 8 - header.size(), ' ')) + records;
  }
  std::string recorded_bag(const std::string& compression) const {
    const std::string type = "sensor_msgs/CompressedImage";
    std::string chunks, records = connection(0, "/left", type) + connection(1, "/right", type) +
                                  connection(2, "/words", "std_msgs/String");
    for (size_t i = 0; i < pairs_.size(); ++i) {
      for (uint32_t side = 0; side < 2; ++side) {
        const image_t& image = pairs_[i].images[side];
        records += bag_message(side, image.utime, ros1_compressed(image));
      }
      records += bag_message(2, pairs_[i].utime, sized("anything"));
      if (i % 4 == 3 || i + 1 == pairs_.size()) {
        chunks +=
            bag_chunk(records, compression) + bag_record(field("op", little(4, 1)), "an index, which is not read");
        records.clear();
      }
    }
    return bag(chunks);
  }

  const testing::TemporaryFolder folder_;
  std::vector<images_t> pairs_;  // of a bundled session
  ImportOptions options_{};
};

}  // namespace multireach
