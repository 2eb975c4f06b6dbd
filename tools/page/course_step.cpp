#include "tools/page/course_step.hpp"

#include "imaging/image_codec.hpp"
#include "runtime/channels.hpp"
#include "runtime/image_message.hpp"

namespace multireach {

void CourseContext::show(int8_t kind, const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation) const {
  if (!practice) return;
  practice_scene_t scene{};
  scene.utime = now_us;
  scene.kind = kind;
  Eigen::Map<Eigen::Vector3d>(scene.position_m) = position;
  Eigen::Map<Eigen::Vector4d>(scene.orientation_wxyz) << orientation.w(), orientation.x(), orientation.y(),
      orientation.z();
  if (auto bytes = encode(scene)) out->push_back({channel::kPracticeScene, std::move(*bytes)});
}

std::array<cv::Mat, 2> decoded_pair(const images_t& images) {
  std::array<cv::Mat, 2> pair;
  ImageCodec codec;
  for (size_t i = 0; i < images.images.size() && i < images.image_types.size(); ++i) {
    const int16_t type = images.image_types[i];
    if (type != images_t::LEFT && type != images_t::RIGHT) continue;
    cv::Mat bgr;
    if (codec.decode(encoded(images.images[i]), bgr)) pair[type == images_t::RIGHT ? 1 : 0] = bgr.clone();
  }
  return pair;
}

std::string jpeg_url(const cv::Mat& bgr) {
  constexpr int kQuality = 85;
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  ImageCodec codec;
  const std::vector<uint8_t> bytes = codec.encode_jpeg(bgr, kQuality);
  std::string text = "data:image/jpeg;base64,";
  for (size_t at = 0; at < bytes.size(); at += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) three = three << 8 | (at + k < bytes.size() ? bytes[at + k] : 0U);
    for (size_t k = 0; k < 4; ++k) text += at + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace multireach
