// Bags of ROS 1, version 2.0 (wiki.ros.org/Bags/Format/2.0).
#include <optional>

#include "tools/log/import/ros_recording.hpp"

namespace multireach {
namespace {

enum Record : uint8_t { kMessage = 0x02, kChunk = 0x05, kConnection = 0x07 };
constexpr std::string_view kMagic = "#ROSBAG V2.0\n";

/// The fields of a record's header: a length, and "name=value", for each.
class Header {
 public:
  explicit Header(ByteReader bytes) : bytes_(std::move(bytes)) {
    ByteReader rest = bytes_;
    while (rest.left() > 0) {
      const std::string_view field = rest.text("a field of a header");
      const size_t equals = field.find('=');
      if (equals == std::string_view::npos) rest.fail("a field of a header has no '='");
      fields_[std::string(field.substr(0, equals))] = field.substr(equals + 1);
    }
  }
  std::string text(const std::string& name) const {
    const auto found = fields_.find(name);
    if (found == fields_.end()) bytes_.fail("the header has no field '" + name + "'");
    return std::string(found->second);
  }
  template <class Integer>
  Integer number(const std::string& name) const {
    const std::string value = text(name);
    if (value.size() != sizeof(Integer))
      bytes_.fail(fmt::format("the field '{}' has {} bytes; expected {}", name, value.size(), sizeof(Integer)));
    return ByteReader(bytes_.place(), {reinterpret_cast<const uint8_t*>(value.data()), value.size()}, bytes_.position())
        .number<Integer>(name);
  }

 private:
  ByteReader bytes_;
  std::map<std::string, std::string_view> fields_;
};

class BagSource : public RosRecording {
 public:
  using RosRecording::RosRecording;

 protected:
  void scan(const Progress& progress) override {
    ByteReader bytes(path(), file());
    bytes.take(kMagic.size(), "the file's beginning");
    while (bytes.left() > 0) {
      if (!complete(bytes)) {
        warn(fmt::format("{}: is cut off at byte {}; the images before it are there", path(), bytes.position()));
        return;
      }
      record(bytes, true);
      progress(static_cast<double>(bytes.position()) / static_cast<double>(file().size()));
    }
  }

 private:
  /// Whether the next record ends before the file does.
  static bool complete(ByteReader bytes) {
    for (int part = 0; part < 2; ++part) {
      if (bytes.left() < 4) return false;
      const auto size = bytes.number<uint32_t>("a length");
      if (size > bytes.left()) return false;
      bytes.take(size, "a part of a record");
    }
    return true;
  }

  static ByteReader part(ByteReader& bytes, std::string_view what) {
    const auto content = bytes.sized(what);
    return {bytes.place(), content, bytes.position() - content.size()};
  }

  void record(ByteReader& bytes, bool in_file) {
    const uint64_t at = bytes.position();
    const Header header(part(bytes, "a record's header"));
    ByteReader data = part(bytes, "a record's data");
    const auto type = header.number<uint8_t>("op");
    if (type == kConnection) {
      const Header connection(data);
      add_topic(header.number<uint32_t>("conn"), {header.text("topic"), connection.text("type"), RosEncoding::kRos1});
    } else if (type == kMessage) {
      add_message(header.number<uint32_t>("conn"), data, in_file);
    } else if (type == kChunk) {
      if (!in_file) data.fail("a chunk is inside of a chunk");
      const std::string compression = header.text("compression");
      const auto size = header.number<uint32_t>("size");
      const uint64_t begin = data.position();
      ByteReader records =
          add_chunk({fmt::format("{}: chunk at byte {}", path(), at), compression == "none" ? "" : compression,
                     data.take(data.left(), "a chunk"), begin, size});
      while (records.left() > 0) record(records, false);
    }
  }
};

}  // namespace

std::unique_ptr<ImageSource> open_bag(const ImportOptions& options) {
  return std::make_unique<BagSource>(options);
}

}  // namespace multireach
