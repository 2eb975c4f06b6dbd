// Imports of recordings whose bytes are laid out here by hand, from the descriptions of their formats.
#include <bzlib.h>
#include <gtest/gtest.h>
#include <lodepng.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <multireach/images_t.hpp>

#include "numeric/random.hpp"
#include "runtime/channels.hpp"
#include "runtime/image_file.hpp"
#include "runtime/image_message.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "tests/input_fault.hpp"
#include "tools/log/export.hpp"
#include "tools/log/import/import.hpp"
#include "tools/replay/session.hpp"

namespace multireach {
namespace {

const std::string kSession = MULTIREACH_SOURCE_DIR "/logs/reach.lcm";
constexpr size_t kPairs = 20;

std::string little(uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text.push_back(i < 8 ? static_cast<char>(value >> 8 * i) : char{0});
  return text;
}
std::string sized(const std::string& bytes) {
  return little(bytes.size(), 4) + bytes;
}

std::string lz4_of(const std::string& bytes) {
  std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
  return out;
}
std::string zstd_of(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  return out;
}
std::string bz2_of(const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 50 + 600, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()), static_cast<unsigned>(bytes.size()), 9,
                           0, 0);
  out.resize(size);
  return out;
}
std::string compressed(const std::string& with, const std::string& bytes) {
  return with == "lz4" ? lz4_of(bytes) : with == "zstd" ? zstd_of(bytes) : with == "bz2" ? bz2_of(bytes) : bytes;
}

class LogImport : public ::testing::Test {
 protected:
  LogImport() {
    char folder[] = "/tmp/multireach-test-XXXXXX";
    folder_ = mkdtemp(folder);
    LogReader log(kSession);
    while (const auto event = log.next()) {
      if (event->channel != channel::kStereoImages || pairs_.size() == kPairs) continue;
      pairs_.push_back(*decode<images_t>(event->data));
    }
    options_.left = "/left";
    options_.right = "/right";
  }
  ~LogImport() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
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

  std::string folder_;
  std::vector<images_t> pairs_;  // of a bundled session
  ImportOptions options_{};
};

TEST_F(LogImport, AFolderWithTimesGivesTheSessionThatItWasMadeOf) {
  std::string table = "time_s,left,right\n";
  for (size_t i = 0; i < pairs_.size(); ++i) {
    char line[100];
    std::snprintf(line, sizeof line, " %lld.%06lld , l/%zu.jpg,r/%zu.jpg\r\n",
                  static_cast<long long>(pairs_[i].utime / 1000000), static_cast<long long>(pairs_[i].utime % 1000000),
                  i, i);
    table += line;
    written("in/l/" + std::to_string(i) + ".jpg", data_of(pairs_[i].images[0]));
    written("in/r/" + std::to_string(i) + ".jpg", data_of(pairs_[i].images[1]));
  }
  written("in/pairs.csv", table + "\n");
  const ImportSummary summary = import(path("in"));
  EXPECT_EQ(summary.pairs, static_cast<int64_t>(kPairs));
  EXPECT_EQ(summary.unpaired, 0);
  EXPECT_EQ(summary.period_us, 33333);
  EXPECT_EQ(summary.width, 320);
  EXPECT_EQ(summary.text().substr(0, 27), "20 pairs of 320 x 240 pixel");
  expect_the_same_pairs();
}

TEST_F(LogImport, FaultsOfAFolderNameFileLineAndWhatWasExpected) {
  const auto said = [&](const std::string& table) {
    written("in/pairs.csv", table);
    return import_fault(path("in"));
  };
  written("in/a.jpg", data_of(pairs_[0].images[0]));
  const std::string file = path("in/pairs.csv");
  EXPECT_EQ(said("time,left,right\n"),
            file +
                ":1: 'time,left,right' are not the names of the columns; expected time_s,left,right or "
                "time_s,left,right,right_time_s");
  EXPECT_EQ(said("time_s,left,right\n1,a.jpg\n"), file + ":2: has 2 values; expected 3: time_s,left,right");
  for (const char* time : {"x", "-1", "1e3", "1.2.3", ".5", "", "99999999999999999999"})
    EXPECT_NE(said(std::string("time_s,left,right\n\n") + time + ",a.jpg,a.jpg\n").find(":3: '"), std::string::npos);
  EXPECT_NE(said("time_s,left,right\n1,a.jpg,a.jpg\n1,a.jpg,a.jpg\n").find(":3: the time 1 is not after"),
            std::string::npos);
  EXPECT_NE(said("time_s,left,right\n1,a.jpg,b.jpg\n").find("b.jpg: cannot be opened"), std::string::npos);
  EXPECT_NE(said("time_s,left,right\n1,a.jpg,pairs.csv\n").find("pairs.csv: is not an image"), std::string::npos);
  EXPECT_NE(said("time_s,left,right\n").find("has no image"), std::string::npos);
  EXPECT_NE(said("time_s,left,right,right_time_s\n1,a.jpg,a.jpg,2\n").find("are at most 0.5 s apart"),
            std::string::npos);
  options_.max_skew_s = 2;
  EXPECT_EQ(said("time_s,left,right,right_time_s\n1,a.jpg,a.jpg,2\n"), "");
  EXPECT_FALSE(std::filesystem::exists(path("other.lcm")));
  std::filesystem::create_directory(path("empty"));
  EXPECT_NE(import_fault(path("empty")).find("expected pairs.csv in it"), std::string::npos);
  EXPECT_NE(import_fault(path("nowhere")).find("nowhere: cannot be opened"), std::string::npos);
  EXPECT_NE(import_fault(written("text.bag", "text")).find("expected a bag of ROS 1"), std::string::npos);
}

TEST_F(LogImport, AnEurocRecordingGivesItsPixelsAndPairsByTime) {
  // Two free-running cameras at 20 Hz: the right one 4 ms later, without its third image.
  constexpr int64_t kBegin = 1403636579758555392;  // ns
  std::string left = "#timestamp [ns],filename\n", right = left;
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 6; ++i) {
    cv::Mat picture(10, 16, CV_8UC1);
    for (int p = 0; p < 160; ++p) picture.data[p] = static_cast<uint8_t>(p + 40 * i);
    const auto png = encode_png(picture);
    const std::string bytes(png.begin(), png.end());
    const std::string name = std::to_string(kBegin + i * 50000000);
    left += name + "," + name + ".png\n";
    written("mh/mav0/cam0/data/" + name + ".png", bytes);
    const std::string later = std::to_string(kBegin + i * 50000000 + 4000000);
    if (i != 2) right += later + "," + later + ".png\n";
    written("mh/mav0/cam1/data/" + later + ".png", bytes);
    pictures.push_back(picture);
  }
  written("mh/mav0/cam0/data.csv", left);
  written("mh/mav0/cam1/data.csv", right);
  options_ = {};
  options_.jpeg_quality = 0;
  for (const char* input : {"mh", "mh/mav0"}) {
    const ImportSummary summary = import(path(input));
    EXPECT_EQ(summary.pairs, 5);
    EXPECT_EQ(summary.unpaired, 1);
    EXPECT_EQ(summary.period_us, 50000);
    EXPECT_EQ(summary.median_skew_us, 4000);
    const std::vector<images_t> pairs = session();
    ASSERT_EQ(pairs.size(), 5U);
    EXPECT_EQ(pairs[2].utime, kBegin / 1000 + 3 * 50000);
    EXPECT_EQ(pairs[2].images[1].utime, kBegin / 1000 + 3 * 50000 + 4000);
    ImageCodec codec;
    cv::Mat bgr;
    for (const image_t& image : pairs[2].images) {
      ASSERT_TRUE(codec.decode(encoded(image), bgr));
      for (int p = 0; p < 160; ++p) ASSERT_EQ(bgr.data[3 * p + 1], pictures[3].data[p]) << p;
    }
  }
  written("mh/mav0/cam1/data.csv", "#timestamp [ns],filename\n12x,a.png\n");
  EXPECT_EQ(import_fault(path("mh")), path("mh/mav0/cam1/data.csv") + ":2: '12x' is not a time; expected nanoseconds");
  options_.right = "cam7";
  EXPECT_NE(import_fault(path("mh")).find("cam7/data.csv: cannot be opened"), std::string::npos);
}

TEST_F(LogImport, McapFilesGiveTheSessionThatTheyWereMadeOf) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    const ImportSummary summary = import(written("run.mcap", recorded_mcap(compression)));
    EXPECT_EQ(summary.pairs, static_cast<int64_t>(kPairs));
    EXPECT_EQ(summary.unpaired, 0);
    EXPECT_EQ(summary.warning, "");
    expect_the_same_pairs();
  }
}

TEST_F(LogImport, BagsGiveTheSessionThatTheyWereMadeOf) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    const ImportSummary summary = import(written("run.bag", recorded_bag(compression)));
    EXPECT_EQ(summary.pairs, static_cast<int64_t>(kPairs));
    EXPECT_EQ(summary.unpaired, 0);
    EXPECT_EQ(summary.warning, "");
    expect_the_same_pairs();
  }
}

// Export's oracle is import, which the tests above compare with files laid out by hand; tests/live/import.sh reads an
// exported bag by ROS's own library.
TEST_F(LogImport, ExportedSessionsGiveTheSessionAgain) {
  const std::string exported = path("exported.lcm");
  {
    LogWriter log(exported);
    for (const images_t& pair : pairs_) log.write(pair.utime, channel::kStereoImages, *encode(pair));
    log.close();
  }
  std::vector<std::string> warnings;
  EXPECT_EQ(export_pairs(exported, path("pairs"), warnings), static_cast<int64_t>(kPairs));
  EXPECT_EQ(import(path("pairs")).pairs, static_cast<int64_t>(kPairs));
  expect_the_same_pairs();
  EXPECT_EQ(export_bag(exported, path("exported.bag"), warnings), static_cast<int64_t>(kPairs));
  options_.left = "/left/image_raw/compressed";
  options_.right = "/right/image_raw/compressed";
  import(path("exported.bag"));
  expect_the_same_pairs();

  EXPECT_EQ(export_euroc(exported, path("euroc"), warnings), static_cast<int64_t>(kPairs));
  options_.left = options_.right = "";
  options_.jpeg_quality = 0;
  EXPECT_EQ(import(path("euroc")).pairs, static_cast<int64_t>(kPairs));
  ImageCodec codec;
  cv::Mat expected, imported;
  const std::vector<images_t> again = session();
  ASSERT_EQ(again.size(), kPairs);
  for (size_t i = 0; i < kPairs; ++i) {
    for (size_t side = 0; side < 2; ++side) {
      ASSERT_TRUE(codec.decode(encoded(pairs_[i].images[side]), expected));
      ASSERT_TRUE(codec.decode(encoded(again[i].images[side]), imported));
      EXPECT_EQ(cv::norm(expected, imported, cv::NORM_INF), 0) << i;
      EXPECT_EQ(again[i].images[side].utime, pairs_[i].images[side].utime);
    }
  }
  EXPECT_TRUE(warnings.empty());
}

TEST_F(LogImport, ExportNamesWhatItLeavesOut) {
  const std::string exported = path("exported.lcm");
  images_t lonely = pairs_[1];
  lonely.images.resize(1);
  lonely.image_types.resize(1);
  lonely.n_images = 1;
  {
    LogWriter log(exported);
    log.write(1, channel::kStereoImages, *encode(pairs_[0]));
    log.write(2, channel::kStereoImages, *encode(lonely));
    log.close();
  }
  std::vector<std::string> warnings;
  EXPECT_EQ(export_bag(exported, path("exported.bag"), warnings), 1);
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_EQ(warnings[0], "event 1: has no left or no right image; left out");
}

TEST_F(LogImport, RawImagesOfRosKeepTheirPixels) {
  // 4 x 2 pixels in rows of 20 bytes: red 10 x + y, green 200, blue 100 + x.
  const auto pixels = [](const std::string& order) {
    std::string data;
    for (int y = 0; y < 2; ++y) {
      std::string row;
      for (int x = 0; x < 4; ++x) {
        for (const char c : order)
          row.push_back(static_cast<char>(c == 'r' ? 10 * x + y : c == 'g' ? 200 : c == 'b' ? 100 + x : 255));
      }
      data += row + std::string(20 - row.size(), '\0');
    }
    return data;
  };
  options_.jpeg_quality = 0;
  for (const auto& [encoding, order] :
       {std::pair("rgb8", "rgb"), {"bgr8", "bgr"}, {"rgba8", "rgba"}, {"bgra8", "bgra"}, {"mono8", "r"}}) {
    SCOPED_TRACE(encoding);
    std::string records = connection(0, "/left", "sensor_msgs/Image") + connection(1, "/right", "sensor_msgs/Image");
    for (uint32_t side = 0; side < 2; ++side)
      records += bag_message(side, 5000000, ros1_raw(5000000, 4, 2, encoding, 20, pixels(order)));
    import(written("raw.bag", bag(bag_chunk(records, "none"))));
    const images_t pair = session().at(0);
    ImageCodec codec;
    cv::Mat bgr;
    ASSERT_TRUE(codec.decode(encoded(pair.images[1]), bgr));
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 4; ++x) {
        const bool grey = std::string(encoding) == "mono8";
        const cv::Vec3b red_level(static_cast<uint8_t>(10 * x + y), static_cast<uint8_t>(10 * x + y),
                                  static_cast<uint8_t>(10 * x + y));
        const cv::Vec3b colour(static_cast<uint8_t>(100 + x), 200, static_cast<uint8_t>(10 * x + y));
        EXPECT_EQ(bgr.at<cv::Vec3b>(y, x), grey ? red_level : colour) << x << " " << y;
      }
    }
  }
}

TEST_F(LogImport, FaultsOfRecordingsNameFileByteAndWhatWasExpected) {
  const std::string one_left = bag_message(0, 5000000, ros1_raw(5000000, 4, 2, "mono8", 4, "12345678"));
  const std::string topics = connection(0, "/left", "sensor_msgs/Image") + connection(1, "/right", "sensor_msgs/Image");
  const auto bag_fault = [&](const std::string& records) { return import_fault(written("x.bag", bag(records))); };
  const std::string file = path("x.bag");
  EXPECT_NE(bag_fault(one_left).find("a message is of the topic number 0, which is not declared"), std::string::npos);
  EXPECT_EQ(bag_fault(topics + one_left), file + ": '/right' has no image; expected at least one");
  const std::string depth = bag_message(1, 5000000, ros1_raw(5000000, 4, 2, "16UC1", 8, std::string(16, ' ')));
  const std::string said = bag_fault(topics + one_left + depth);
  EXPECT_NE(said.find(": the encoding '16UC1' is not supported; expected one of rgba8, bgra8, mono8"),
            std::string::npos)
      << said;
  EXPECT_TRUE(said.starts_with(file + ": byte ")) << said;
  const std::string wide = bag_message(1, 5000000, ros1_raw(5000000, 400000, 2, "mono8", 4, "12345678"));
  EXPECT_NE(bag_fault(topics + one_left + wide).find("the image has 400000 x 2 pixels; expected 2 to 16384"),
            std::string::npos);
  const std::string too_few = bag_message(1, 5000000, ros1_raw(5000000, 4, 2, "mono8", 4, "1234"));
  EXPECT_NE(bag_fault(topics + one_left + too_few).find("cannot be decoded"), std::string::npos);
  EXPECT_NE(
      bag_fault(bag_record(field("op", little(5, 1)) + field("compression", "xz") + field("size", little(9, 4)), "x"))
          .find("has the compression 'xz'; expected none, lz4, zstd or bz2"),
      std::string::npos);
  EXPECT_NE(
      bag_fault(bag_record(field("op", little(5, 1)) + field("compression", "bz2") + field("size", little(9, 4)), "x"))
          .find(": chunk at byte 4109: its bz2 data are damaged"),
      std::string::npos);
  EXPECT_NE(bag_fault(bag_record(field("op", little(5, 1)) + field("compression", "lz4") +
                                     field("size", little(0xfffffff0, 4)),
                                 "x"))
                .find("at most 1 GB"),
            std::string::npos);
  EXPECT_NE(bag_fault(bag_record("\x05\1\1\1", "")).find("expected a field of a header of 16843013 bytes"),
            std::string::npos);

  written("run.mcap", recorded_mcap("zstd"));
  options_.left = "";
  EXPECT_EQ(import_fault(path("run.mcap")),
            path("run.mcap") + ": --left is missing; expected a topic; its topics with images are /left, /right");
  options_.left = "/words";
  EXPECT_NE(import_fault(path("run.mcap")).find("is of type 'std_msgs/msg/String'"), std::string::npos);
  options_.left = "/nothing";
  EXPECT_NE(import_fault(path("run.mcap")).find("has no topic '/nothing' (--left)"), std::string::npos);
  options_.left = "/right";
  EXPECT_NE(import_fault(path("run.mcap")).find("the same topic"), std::string::npos);
  options_.left = "/left";
  std::string damaged = recorded_mcap("");
  damaged[damaged.size() / 14] ^= 1;  // in an image of the first chunk, which has a checksum
  EXPECT_NE(import_fault(written("damaged.mcap", damaged)).find("does not have the checksum"), std::string::npos);

  // A recorder that was killed leaves what it had written.
  const std::string whole = recorded_mcap("lz4");
  const ImportSummary cut = import(written("cut.mcap", whole.substr(0, whole.size() * 2 / 3)));
  EXPECT_GT(cut.pairs, 5);
  EXPECT_LT(cut.pairs, static_cast<int64_t>(kPairs));
  EXPECT_NE(cut.warning.find("is cut off at byte "), std::string::npos);
}

/// No damage crashes a reader, takes much memory, or gives more images than were recorded.
TEST_F(LogImport, DamagedRecordingsAreReadOrRefusedInASentence) {
  constexpr uint64_t kSeed = 23;
  const char* number = std::getenv("MULTIREACH_LOG_MUTATIONS");
  const uint64_t mutations = number ? std::strtoull(number, nullptr, 10) : 1500;
  pairs_.resize(4);
  const std::vector<std::string> whole{recorded_mcap(""),    recorded_mcap("lz4"), recorded_mcap("zstd"),
                                       recorded_bag("none"), recorded_bag("bz2"),  recorded_bag("lz4")};
  const CounterRandom random(kSeed);
  uint64_t refused = 0;
  for (uint64_t k = 0; k < mutations && !HasFailure(); ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", recording " + std::to_string(k));
    uint64_t counter = k * 64;
    const auto below = [&](size_t limit) { return static_cast<size_t>(random.bits(counter++) % limit); };
    std::string bytes = whole[k % whole.size()];
    for (size_t changes = 1 + below(3); changes > 0; --changes) {
      // Half of the damage is in the first bytes of a chunk, where the lengths are.
      const size_t at = below(2) ? below(bytes.size()) : below(std::min<size_t>(bytes.size(), 5000));
      if (below(4) == 0) {
        bytes.erase(at, 1 + below(50));
      } else if (below(3) == 0) {
        bytes[at] = static_cast<char>(below(2) ? 0xff : 0x7f);
      } else {
        bytes[at] ^= static_cast<char>(1 << below(8));
      }
    }
    if (below(10) == 0) bytes.resize(1 + below(bytes.size()));
    try {
      const ImportSummary summary = import(written("damaged", bytes));
      EXPECT_LE(summary.pairs, 2 * static_cast<int64_t>(pairs_.size()));
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("damaged"), std::string::npos);
      ++refused;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "no sentence for users: " << error.what();
    }
  }
  EXPECT_GT(refused, mutations / 20) << "most damage to lengths is noticed";
  RecordProperty("refused", static_cast<int>(refused));
}

}  // namespace
}  // namespace multireach
