#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/mapped_file.hpp"
#include "tools/log/import/image_source.hpp"
#include "tools/log/import/ros_image.hpp"

namespace multireach {

/// Two image topics of a recording of ROS. What a file format has of its own is how its messages are found.
class RosRecording : public ImageSource {
 public:
  explicit RosRecording(const ImportOptions& options);

  std::vector<ListedImage> list(const Progress& progress) override;
  Frame read(const ListedImage& image) override;
  std::string warning() const override { return warning_; }

 protected:
  /// A part of the file with messages, possibly compressed.
  struct Chunk {
    std::string name;         ///< for errors
    std::string compression;  ///< "" for none
    std::span<const uint8_t> data;
    uint64_t offset = 0;  ///< of the data in the file
    uint64_t size = 0;    ///< decompressed
  };
  /// A topic of the recording.
  struct Topic {
    std::string name, type;
    RosEncoding encoding = RosEncoding::kCdr;
  };

  /// Calls add_topic, add_chunk and add_message for what the file holds.
  virtual void scan(const Progress& progress) = 0;

  const std::string& path() const { return options_.input; }
  std::span<const uint8_t> file() const { return file_.bytes(); }
  void warn(const std::string& sentence) { warning_ = sentence; }
  void add_topic(uint32_t id, Topic topic);
  /// Decompresses the chunk and makes it the one of the following messages. Returns its bytes.
  ByteReader add_chunk(Chunk chunk);
  /// A message of a topic: bytes of the chunk, or, with `in_file`, of the file outside of chunks.
  void add_message(uint32_t topic, ByteReader message, bool in_file);

 private:
  struct Message {
    size_t chunk = 0, offset = 0, size = 0;
    Topic* topic = nullptr;
    int64_t utime = 0;
  };
  std::span<const uint8_t> bytes_of(size_t chunk);
  std::optional<Side> side_of(const Topic& topic) const;
  std::string image_topics() const;
  void check_topics() const;

  ImportOptions options_;
  MappedFile file_;
  ImageStore store_;
  std::map<uint32_t, Topic> topics_;
  std::vector<Chunk> chunks_;  // the first one is the whole file
  std::vector<Message> messages_;
  std::vector<ListedImage> images_;
  struct Decompressed {
    size_t chunk = 0;
    std::vector<uint8_t> bytes;
  };
  std::array<Decompressed, 2> cache_;  // the chunks used last, newest first
  std::string warning_;
};

std::unique_ptr<ImageSource> open_mcap(const ImportOptions& options);
std::unique_ptr<ImageSource> open_bag(const ImportOptions& options);

}  // namespace multireach
