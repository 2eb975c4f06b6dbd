#include "runtime/nodes/vision_node.hpp"

#include <charconv>
#include <future>

#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/nodes/rig_config.hpp"

namespace multireach {

using vision::CameraModel;
using vision::Sighting;

namespace {

vision::ColourClass colour_class_from(const Config& config) {
  vision::ColourClass colour;
  for (const Config& reference : config.sections("references")) {
    const std::vector<double> rgb = reference.numbers("rgb", 3);
    for (const double channel : rgb) {
      if (channel < 0 || channel > 255) reference.fail("rgb", "three numbers from 0 to 255");
    }
    if (rgb[0] + rgb[1] + rgb[2] < 1) reference.fail("rgb", "a colour that is not black");
    reference.finish();
    colour.references.push_back({rgb[0], rgb[1], rgb[2]});
  }
  if (colour.references.empty()) config.fail("references", "at least one colour");
  colour.tolerance = config.number("tolerance", 0, 100, colour.tolerance);
  colour.darkest = config.number("darkest", 0, 255, colour.darkest);
  colour.brightest = config.number("brightest", 0, 255, colour.brightest);
  config.finish();
  return colour;
}

}  // namespace

VisionConfig VisionConfig::load(const std::string& path) {
  const Config file = Config::load(path);
  VisionConfig vision;
  const RigConfig cameras = load_rig(file.section("cameras"));
  vision.digest = digest_of(read_text_file(path) + cameras.files);
  vision.tracker.rig = cameras.rig;
  vision.tracker.colour = colour_class_from(file.section("colour"));
  vision.target_name = "target";
  if (file.has("tracker")) {
    const Config tracker = file.section("tracker");
    vision::TrackerOptions& options = vision.tracker;
    vision.target_name = tracker.text("target_name", vision.target_name);
    options.ball_radius_m = tracker.number("ball_radius_m", 0, 10, options.ball_radius_m);
    options.min_area_px = tracker.number("min_area_px", 1, 1e9, options.min_area_px);
    options.sigma_px = tracker.number("sigma_px", 1e-6, 1000, options.sigma_px);
    options.max_epipolar_px = tracker.number("max_epipolar_px", 1e-6, 1e6, options.max_epipolar_px);
    tracker.finish();
  }
  file.finish();
  try {
    vision::StereoTracker check(vision.tracker);
  } catch (const std::invalid_argument& fault) {
    throw InputError(path + ": " + fault.what());
  }
  return vision;
}

int64_t pair_sequence(const images_t& images) {
  for (const image_t& image : images.images) {
    for (const image_metadata_t& item : image.metadata) {
      if (item.key != "sequence") continue;
      int64_t value = -1;
      const char* begin = reinterpret_cast<const char*>(item.value.data());
      const auto [end, error] = std::from_chars(begin, begin + item.value.size(), value);
      if (error == std::errc() && end == begin + item.value.size() && value >= 0) return value;
    }
  }
  return -1;
}

vision::EncodedImage encoded(const image_t& image) {
  return {.width = image.width,
          .height = image.height,
          .row_stride = image.row_stride,
          .format = static_cast<vision::PixelFormat>(image.pixelformat),
          .data = image.data};
}

Eyes::Eyes(const VisionConfig& config, int threads) : tracker_(config.tracker), side_by_side_(threads > 1) {}

namespace {

const image_t* image_of_type(const images_t& images, int16_t type) {
  for (size_t i = 0; i < images.images.size(); ++i) {
    if (images.image_types[i] == type) return &images.images[i];
  }
  return nullptr;
}

bool fits(const image_t& image, const CameraModel& camera) {
  return image.width == camera.width && image.height == camera.height;
}

}  // namespace

Glimpse Eyes::look(std::span<const uint8_t> message) {
  Glimpse glimpse;
  const auto images = decode<images_t>(message);
  if (!images) return glimpse;
  glimpse.decoded = true;
  glimpse.utime = images->utime;
  glimpse.pair_sequence = pair_sequence(*images);
  const image_t* left = image_of_type(*images, images_t::LEFT);
  const image_t* right = image_of_type(*images, images_t::RIGHT);
  if (left) glimpse.left_utime = left->utime;
  if (right) glimpse.right_utime = right->utime;
  // Before decoding: an image of another size is of no use, whatever memory it asks for.
  const vision::StereoRig& rig = tracker_.options().rig;
  if (!left || !right || !fits(*left, rig.left) || !fits(*right, rig.right)) return glimpse;
  const auto look_at = [this](vision::Side side, const image_t& image, Eye& eye, vision::View& view) {
    if (!eye.codec.decode(encoded(image), eye.bgr)) return false;
    view = tracker_.look(side, eye.bgr);
    return true;
  };
  const auto policy = side_by_side_ ? std::launch::async : std::launch::deferred;
  auto beside =
      std::async(policy, look_at, vision::Side::kRight, std::cref(*right), std::ref(right_), std::ref(glimpse.right));
  const bool left_readable = look_at(vision::Side::kLeft, *left, left_, glimpse.left);
  glimpse.readable = beside.get() && left_readable;
  return glimpse;
}

VisionNode::VisionNode(const VisionConfig& config, int threads)
    : config_(config), eyes_(config, threads), tracker_(config.tracker) {}

std::vector<std::string_view> VisionNode::inputs() const {
  return {channel::kStereoImages};
}

target_t VisionNode::target_of(const Glimpse& glimpse) {
  target_t target{};
  target.name = config_.target_name;
  target.utime = glimpse.utime;
  target.sequence = sequence_++;
  target.pair_sequence = glimpse.pair_sequence;
  target.left_frame_utime = glimpse.left_utime;
  target.right_frame_utime = glimpse.right_utime;
  target.status = target_t::STATUS_LOST;
  std::copy_n(last_seen_.position_m, 3, target.position_m);
  if (!glimpse.readable) {
    ++counters_.refused;
    state_ = "unreadable image, or of another size than the calibration";
    return target;
  }
  const Sighting sighting = tracker_.find(glimpse.left, glimpse.right);
  Eigen::Map<Eigen::Vector2d>(target.left_px) = sighting.left_px;
  Eigen::Map<Eigen::Vector2d>(target.right_px) = sighting.right_px;
  target.epipolar_error_px = sighting.point.epipolar_error_px;
  state_ = description(sighting.status);
  if (sighting.status != Sighting::Status::kSeen) return target;
  target.status = target_t::STATUS_TRACKED;
  Eigen::Map<Eigen::Vector3d>(target.position_m) = sighting.point.p_W;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target.covariance_m2[0][0]) = sighting.point.covariance;
  last_seen_ = target;
  return target;
}

bool VisionNode::adopt(std::span<const uint8_t> sent) {
  const auto target = decode<target_t>(sent);
  if (!target || target->sequence != sequence_) return false;
  ++sequence_;
  if (target->status == target_t::STATUS_TRACKED) last_seen_ = *target;
  return true;
}

Receipt VisionNode::receive(std::string_view, std::span<const uint8_t> bytes, Outbox& out) {
  return conclude(eyes_.look(bytes), out);
}

Receipt VisionNode::conclude(const Glimpse& glimpse, Outbox& out) {
  ++(glimpse.decoded ? counters_.received : counters_.refused);
  if (!glimpse.decoded) return {};
  if (!plausible_utime(glimpse.utime)) {
    ++counters_.refused;
    return {};
  }
  const target_t target = target_of(glimpse);
  if (target.pair_sequence >= 0) counters_.dropped += pairs_.missing_before(target.pair_sequence);
  send(out, channel::kTarget, target);
  return {Receipt::Effect::kTaken, glimpse.utime, target.pair_sequence};
}

}  // namespace multireach
