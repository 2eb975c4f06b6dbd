// MCAP (mcap.dev/spec, version 0), as rosbag2 writes it.
#include <lodepng.h>

#include "tools/log/import/ros_recording.hpp"

namespace multireach {
namespace {

enum Record : uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0f
};
constexpr size_t kMagic = 8;         // bytes
constexpr size_t kRecordHeader = 9;  // bytes: type and length

class McapSource : public RosRecording {
 public:
  using RosRecording::RosRecording;

 protected:
  void scan(const Progress& progress) override {
    ByteReader bytes(path(), file());
    bytes.take(kMagic, "the file's beginning");
    while (bytes.left() > 0) {
      const uint64_t at = bytes.position();
      if (bytes.left() < kRecordHeader) return cut_off(at);
      const auto type = bytes.number<uint8_t>("a record's type");
      const auto length = bytes.number<uint64_t>("a record's length");
      if (type == kDataEnd || type == kFooter) return;
      if (length > bytes.left()) return cut_off(at);
      record(type, part(bytes, length), at, true);
      progress(static_cast<double>(bytes.position()) / static_cast<double>(file().size()));
    }
    cut_off(file().size());
  }

 private:
  static ByteReader part(ByteReader& bytes, uint64_t length) {
    const uint64_t at = bytes.position();
    return {bytes.place(), bytes.take(length, "a record"), at};
  }

  void cut_off(uint64_t at) {
    warn(fmt::format("{}: is cut off at byte {}; the images before it are there", path(), at));
  }

  void record(uint8_t type, ByteReader content, uint64_t at, bool in_file) {
    if (type == 0) content.fail("a record has the type 0; expected 1 to 255");
    if (type == kSchema) {
      const auto id = content.number<uint16_t>("a schema's number");
      schemas_[id] = content.text("a schema's name");
    } else if (type == kChannel) {
      const auto id = content.number<uint16_t>("a channel's number");
      const auto schema = content.number<uint16_t>("a channel's schema");
      const std::string topic(content.text("a channel's topic"));
      const std::string encoding(content.text("a channel's encoding"));
      const bool known = encoding == "cdr" || encoding == "ros1";
      // Another encoding is one of messages that are not ROS's images, whatever their schema is called.
      add_topic(id, {topic, known ? schemas_[schema] : encoding + " " + schemas_[schema],
                     encoding == "ros1" ? RosEncoding::kRos1 : RosEncoding::kCdr});
    } else if (type == kMessage) {
      const auto channel = content.number<uint16_t>("a message's channel");
      content.take(4 + 8 + 8, "a message's number and times");
      const uint64_t begin = content.position();
      add_message(channel, {content.place(), content.take(content.left(), "a message"), begin}, in_file);
    } else if (type == kChunk) {
      if (!in_file) content.fail("a chunk is inside of a chunk");
      chunk(content, at);
    }
  }

  void chunk(ByteReader& content, uint64_t at) {
    content.take(8 + 8, "a chunk's times");
    const auto size = content.number<uint64_t>("a chunk's size");
    const auto crc = content.number<uint32_t>("a chunk's checksum");
    const std::string compression(content.text("a chunk's compression"));
    const auto length = content.number<uint64_t>("the length of a chunk's records");
    const uint64_t begin = content.position();
    const auto data = content.take(length, "a chunk's records");
    const std::string name = fmt::format("{}: chunk at byte {}", path(), at);
    ByteReader records = add_chunk({name, compression, data, begin, size});
    const auto all = ByteReader(records).take(records.left(), "a chunk's records");
    if (crc != 0 && lodepng_crc32(all.data(), all.size()) != crc)
      throw InputError(name + ": does not have the checksum that it states; it is damaged");
    while (records.left() > 0) {
      const uint64_t begins = records.position();
      const auto type = records.number<uint8_t>("a record's type");
      const auto bytes = records.number<uint64_t>("a record's length");
      record(type, part(records, bytes), begins, false);
    }
  }

  std::map<uint16_t, std::string> schemas_;
};

}  // namespace

std::unique_ptr<ImageSource> open_mcap(const ImportOptions& options) {
  return std::make_unique<McapSource>(options);
}

}  // namespace multireach
