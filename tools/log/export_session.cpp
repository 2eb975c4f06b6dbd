// Sessions as recordings of other programs: what multireach-log import reads.
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <functional>
#include <future>
#include <multireach/images_t.hpp>

#include "imaging/image_codec.hpp"
#include "runtime/channels.hpp"
#include "runtime/image_file.hpp"
#include "runtime/image_message.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/progress.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"

namespace multireach {
namespace {

constexpr std::array kSideNames{"left", "right"};

/// Calls `use` with the left and the right image of each pair of a session, in the order of the log. Returns their
/// number. Messages without both images are listed in `warnings`.
int64_t for_each_pair(const std::string& log, std::vector<std::string>& warnings,
                      const std::function<void(int64_t number, const std::array<const image_t*, 2>&)>& use) {
  LogReader reader(log);
  Progress progress;
  int64_t pairs = 0;
  while (const auto event = reader.next()) {
    progress.show(static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
    const auto message = event->channel == channel::kStereoImages ? decode<images_t>(event->data) : std::nullopt;
    if (!message) continue;
    std::array<const image_t*, 2> sides{};
    for (size_t i = 0; i < message->images.size(); ++i) {
      if (message->image_types[i] == images_t::LEFT) sides[0] = &message->images[i];
      if (message->image_types[i] == images_t::RIGHT) sides[1] = &message->images[i];
    }
    if (!sides[0] || !sides[1]) {
      warnings.push_back(fmt::format("event {}: has no left or no right image; left out", event->number));
      continue;
    }
    use(pairs++, sides);
  }
  report_damage(log, reader);
  return pairs;
}

/// An image as the bytes of a PNG file. Throws InputError.
std::vector<uint8_t> png_of(ImageCodec& codec, const image_t& image, const std::string& log) {
  cv::Mat bgr;
  if (!codec.decode(encoded(image), bgr))
    throw InputError(fmt::format("{}: the image of {} us cannot be decoded", log, image.utime));
  return encode_png(bgr);
}

/// An image as the bytes of a file, of which JPEG data stay as they are, and the name of its format.
std::pair<std::vector<uint8_t>, const char*> file_of(ImageCodec& codec, const image_t& image, const std::string& log) {
  if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) return {image.data, "jpeg"};
  return {png_of(codec, image, log), "png"};
}

void write_file(const std::string& path, std::span<const uint8_t> bytes) {
  OutputFile file(path);
  file.write(bytes);
  file.finish();
}

/// Throws OutputError when the folder cannot be made.
void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw OutputError(folder + ": cannot be made: " + error.message());
}

std::string seconds(int64_t utime) {
  return fmt::format("{}.{:06}", utime / 1000000, utime % 1000000);
}

/// Numbers and fields as a bag of ROS 1 holds them.
template <class Number>
std::string little(Number value) {
  std::string bytes;
  for (size_t i = 0; i < sizeof(Number); ++i) bytes.push_back(static_cast<char>(static_cast<uint64_t>(value) >> 8 * i));
  return bytes;
}
std::string sized(std::string_view bytes) {
  return little(static_cast<uint32_t>(bytes.size())) + std::string(bytes);
}
std::string field(std::string_view name, std::string_view value) {
  return sized(std::string(name) + "=" + std::string(value));
}
std::string record(std::string_view header, std::string_view data) {
  return sized(header) + sized(data);
}
std::string ros_time(int64_t utime) {
  return little(static_cast<uint32_t>(utime / 1000000)) + little(static_cast<uint32_t>(utime % 1000000 * 1000));
}

constexpr const char* kCompressedImage = "sensor_msgs/CompressedImage";
constexpr const char* kCompressedImageMd5 = "8f7a12909da2c9d3332d540a0977563f";
constexpr const char* kCompressedImageDefinition =
    "std_msgs/Header header\nstring format\nuint8[] data\n"
    "================================================================================\n"
    "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";

/// The records of a bag (wiki.ros.org/Bags/Format/2.0), uncompressed, in chunks of about a megabyte.
class BagRecords {
 public:
  using Sink = std::function<void(std::string_view)>;

  /// `index`: position of the first record after the chunks; its value does not change any size.
  BagRecords(Sink sink, uint64_t index, uint32_t chunks) : sink_(std::move(sink)) {
    put("#ROSBAG V2.0\n");
    const std::string header = field("op", "\x03") + field("index_pos", little(index)) +
                               field("conn_count", little(uint32_t{2})) + field("chunk_count", little(chunks));
    put(record(header, std::string(kHeaderSize - 8 - header.size(), ' ')));
  }
  void add(size_t side, int64_t utime, uint32_t number, std::string_view format, std::span<const uint8_t> image) {
    if (chunk_.empty()) {
      begin_ = utime;
      chunk_ = connection(0) + connection(1);
    }
    end_ = std::max(end_, utime);
    const std::string data = little(number) + ros_time(utime) + sized(kSideNames[side]) + sized(format) +
                             sized({reinterpret_cast<const char*>(image.data()), image.size()});
    entries_[side] += ros_time(utime) + little(static_cast<uint32_t>(chunk_.size()));
    ++counts_[side];
    chunk_ += record(
        field("op", "\x02") + field("conn", little(static_cast<uint32_t>(side))) + field("time", ros_time(utime)),
        data);
    if (chunk_.size() > kChunkSize) end_chunk();
  }
  void finish() {
    if (!chunk_.empty()) end_chunk();
    index_ = position_;
    for (size_t side = 0; side < 2; ++side) put(connection(side));
    for (const std::string& info : infos_) put(info);
  }
  uint64_t index() const { return index_; }
  uint32_t chunks() const { return static_cast<uint32_t>(infos_.size()); }

 private:
  static constexpr size_t kHeaderSize = 4096, kChunkSize = 1 << 20;

  static std::string connection(size_t side) {
    const std::string topic = std::string("/") + kSideNames[side] + "/image_raw/compressed";
    return record(field("op", "\x07") + field("conn", little(static_cast<uint32_t>(side))) + field("topic", topic),
                  field("topic", topic) + field("type", kCompressedImage) + field("md5sum", kCompressedImageMd5) +
                      field("message_definition", kCompressedImageDefinition));
  }
  void put(std::string_view bytes) {
    sink_(bytes);
    position_ += bytes.size();
  }
  void end_chunk() {
    std::string connections;
    uint32_t used = 0;
    for (size_t side = 0; side < 2; ++side) {
      if (counts_[side] == 0) continue;
      connections += little(static_cast<uint32_t>(side)) + little(counts_[side]);
      ++used;
    }
    infos_.push_back(record(field("op", "\x06") + field("ver", little(uint32_t{1})) +
                                field("chunk_pos", little(position_)) + field("start_time", ros_time(begin_)) +
                                field("end_time", ros_time(end_)) + field("count", little(used)),
                            connections));
    put(record(field("op", "\x05") + field("compression", "none") +
                   field("size", little(static_cast<uint32_t>(chunk_.size()))),
               chunk_));
    for (size_t side = 0; side < 2; ++side) {
      if (counts_[side] == 0) continue;
      put(record(field("op", "\x04") + field("ver", little(uint32_t{1})) +
                     field("conn", little(static_cast<uint32_t>(side))) + field("count", little(counts_[side])),
                 entries_[side]));
    }
    chunk_.clear();
    entries_ = {};
    counts_ = {};
    end_ = 0;
  }

  Sink sink_;
  uint64_t position_ = 0, index_ = 0;
  std::string chunk_;
  std::array<std::string, 2> entries_;
  std::array<uint32_t, 2> counts_{};
  int64_t begin_ = 0, end_ = 0;
  std::vector<std::string> infos_;
};

}  // namespace

int64_t export_pairs(const std::string& log, const std::string& folder, std::vector<std::string>& warnings) {
  make_folder(folder);
  for (const char* side : kSideNames) make_folder(folder + "/" + side);
  ImageCodec codec;
  std::string table = "time_s,left,right,right_time_s\n";
  const int64_t pairs = for_each_pair(log, warnings, [&](int64_t number, const std::array<const image_t*, 2>& images) {
    std::array<std::string, 2> names;
    for (size_t side = 0; side < 2; ++side) {
      const auto [bytes, format] = file_of(codec, *images[side], log);
      names[side] =
          fmt::format("{}/{:06}.{}", kSideNames[side], number, std::string_view(format) == "jpeg" ? "jpg" : format);
      write_file(folder + "/" + names[side], bytes);
    }
    table += seconds(images[0]->utime) + "," + names[0] + "," + names[1] + "," + seconds(images[1]->utime) + "\n";
  });
  write_text_file(folder + "/pairs.csv", table);
  return pairs;
}

int64_t export_euroc(const std::string& log, const std::string& folder, std::vector<std::string>& warnings) {
  std::array<std::string, 2> cameras, tables;
  for (size_t side = 0; side < 2; ++side) {
    cameras[side] = fmt::format("{}/mav0/cam{}", folder, side);
    make_folder(cameras[side] + "/data");
    tables[side] = "#timestamp [ns],filename\n";
  }
  std::array<ImageCodec, 2> codecs;
  const int64_t pairs = for_each_pair(log, warnings, [&](int64_t, const std::array<const image_t*, 2>& images) {
    const auto write = [&](size_t side) {
      const int64_t ns = images[side]->utime * 1000;
      write_file(fmt::format("{}/data/{}.png", cameras[side], ns), png_of(codecs[side], *images[side], log));
      tables[side] += fmt::format("{},{}.png\n", ns, ns);
    };
    auto right = std::async(std::launch::async, write, 1);  // PNG takes long
    write(0);
    right.get();
  });
  for (size_t side = 0; side < 2; ++side) write_text_file(cameras[side] + "/data.csv", tables[side]);
  return pairs;
}

int64_t export_bag(const std::string& log, const std::string& file, std::vector<std::string>& warnings) {
  ImageCodec codec;
  const auto write = [&](BagRecords& bag) {
    warnings.clear();
    const int64_t pairs =
        for_each_pair(log, warnings, [&](int64_t number, const std::array<const image_t*, 2>& images) {
          for (size_t side = 0; side < 2; ++side) {
            const auto [bytes, format] = file_of(codec, *images[side], log);
            bag.add(side, images[side]->utime, static_cast<uint32_t>(number), format, bytes);
          }
        });
    bag.finish();
    return pairs;
  };
  // The header, at the beginning, names the position of the index and the number of chunks: they are counted first.
  BagRecords counted([](std::string_view) {}, 0, 0);
  write(counted);
  OutputFile out(file);
  BagRecords bag(
      [&](std::string_view bytes) {
        out.write({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
      },
      counted.index(), counted.chunks());
  const int64_t pairs = write(bag);
  out.finish();
  return pairs;
}

}  // namespace multireach
