#include <fmt/format.h>

#include <filesystem>
#include <multireach/images_t.hpp>

#include "imaging/image_codec.hpp"
#include "runtime/image_file.hpp"
#include "runtime/image_message.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/progress.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"

namespace multireach {

int64_t export_images(const std::string& log, const std::string& folder, const ChannelPatterns& patterns,
                      std::vector<std::string>& warnings) {
  LogReader reader(log);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  ImageCodec codec;
  cv::Mat bgr;
  int64_t written = 0, messages = 0;
  Progress progress;
  while (const auto event = reader.next()) {
    progress.show(static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
    const auto images = matches_any(patterns, event->channel) ? decode<images_t>(event->data) : std::nullopt;
    if (!images) continue;
    const int64_t number = messages++;
    for (size_t i = 0; i < images->images.size(); ++i) {
      const image_t& image = images->images[i];
      const std::string side = images->image_types[i] == images_t::LEFT    ? "left"
                               : images->image_types[i] == images_t::RIGHT ? "right"
                                                                           : std::to_string(images->image_types[i]);
      const std::string path = fmt::format("{}/{:06}_{}.png", folder, number, side);
      if (!codec.decode(encoded(image), bgr)) {
        warnings.push_back(fmt::format("event {}: the {} image cannot be decoded", event->number, side));
        continue;
      }
      OutputFile file(path);
      file.write(encode_png(bgr));
      file.finish();
      ++written;
    }
  }
  report_damage(log, reader);
  return written;
}

}  // namespace multireach
