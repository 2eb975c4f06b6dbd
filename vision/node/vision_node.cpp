#include "vision/node/vision_node.hpp"

#include <fmt/format.h>

#include <future>
#include <multireach/debug_request_t.hpp>
#include <utility>

#include "runtime/channels.hpp"
#include "vision/node/debug_picture.hpp"

namespace multireach {
namespace {

using vision::StereoMatch;
using Status = vision::TargetTrack::Status;

constexpr std::array kSides{Side::kLeft, Side::kRight};
constexpr int64_t kPicturesFor = 2000000;  // us, how long one request sends debug pictures

int8_t wire_status(Status status) {
  switch (status) {
    case Status::kTracked:
      return target_t::STATUS_TRACKED;
    case Status::kCoasting:
      return target_t::STATUS_COASTING;
    case Status::kLost:
      break;
  }
  return target_t::STATUS_LOST;
}

const char* word_for(int8_t status) {
  return status == target_t::STATUS_TRACKED ? "tracked" : status == target_t::STATUS_COASTING ? "coasting" : "lost";
}

void put(double (&field)[3], const Eigen::Vector3d& vector) {
  std::copy_n(vector.data(), 3, field);
}

void put(double (&field)[3][3], const Eigen::Matrix3d& matrix) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rows(&field[0][0]);
  rows = matrix;
}

vision::PairTimes times_of(const StereoFrames& frames) {
  return {frames.utime(), frames.frame_utime(Side::kLeft), frames.frame_utime(Side::kRight)};
}

}  // namespace

VisionNode::VisionNode(const VisionConfig& config, int threads) : config_(config), side_by_side_(threads > 1) {
  for (const VisionConfig::Target& target : config.targets) {
    targets_.push_back({target.name, vision::StereoTracker(target.options)});
  }
}

std::vector<std::string_view> VisionNode::inputs() const {
  return {channel::kStereoImages, channel::kVisionDebugRequest};
}

/// Searches one image for every target: in its window, or, when `everywhere`, in the whole image for those not found.
bool VisionNode::look(StereoFrames& frames, Side side, bool everywhere) {
  const auto at = static_cast<size_t>(index(side));
  std::vector<cv::Rect> windows;
  cv::Rect part;
  for (const Target& target : targets_) {
    windows.push_back(everywhere ? target.tracker.whole_image(side) : target.tracker.window(side, frames.utime()));
    part |= windows.back();
  }
  const cv::Mat* bgr = frames.pixels(side, part, codecs_[at]);
  if (!bgr) return false;
  for (size_t k = 0; k < targets_.size(); ++k) {
    Target& target = targets_[k];
    if (everywhere && target.enough) continue;
    if (target.views[at].window != windows[k]) target.views[at] = target.tracker.look(side, *bgr, windows[k]);
  }
  return true;
}

bool VisionNode::look_at_both(StereoFrames& frames, bool everywhere) {
  const auto policy = side_by_side_ ? std::launch::async : std::launch::deferred;
  auto right = std::async(policy, [&] { return look(frames, Side::kRight, everywhere); });
  const bool left = look(frames, Side::kLeft, everywhere);
  if (!right.get() || !left) return false;
  for (Target& target : targets_) {
    if (everywhere && target.enough) continue;
    target.match = target.tracker.match(times_of(frames), target.views[0], target.views[1]);
    target.enough = target.tracker.enough(target.match, target.views[0], target.views[1]);
  }
  return true;
}

/// Processes the pair for all targets. Returns why the pair as a whole is unusable, or null.
const char* VisionNode::fault_of(StereoFrames& frames) {
  const StereoRig& rig = config_.rig;
  for (Target& target : targets_) {
    if (target.tracker.begin(frames.utime())) watch_ = {};
    target.views = {};
    target.match = {};
    target.enough = false;
  }
  if (frames.frame_utime(Side::kLeft) < 0) return "there is no left image";
  if (frames.frame_utime(Side::kRight) < 0) return "there is no right image";
  // Check sizes before decoding, so that a wrong or damaged size allocates no memory.
  if (!frames.has(Side::kLeft, rig.left.width, rig.left.height) ||
      !frames.has(Side::kRight, rig.right.width, rig.right.height)) {
    return vision::description(StereoMatch::Status::kWrongImageSize);
  }
  watch_.take(frames.fingerprint(Side::kLeft), frames.fingerprint(Side::kRight));
  if (!look_at_both(frames, false)) return "an image cannot be decoded";
  const bool all = std::ranges::all_of(targets_, &Target::enough);
  if (!all && !look_at_both(frames, true)) return "an image cannot be decoded";
  // A covered camera also repeats a black image; the tracker reports that case as dark.
  const auto frozen = watch_.frozen();
  const auto black = [&](const Target& target) { return target.views[static_cast<size_t>(index(*frozen))].dark; };
  if (frozen && std::ranges::none_of(targets_, black)) {
    return *frozen == Side::kLeft ? "the left camera is frozen: it gives the same image again and again"
                                  : "the right camera is frozen: it gives the same image again and again";
  }
  return nullptr;
}

target_t VisionNode::target_of(Target& target, const StereoFrames& frames, const char* fault) {
  const vision::TargetReport report =
      fault ? target.tracker.take_unseen(frames.utime(), fault)
            : target.tracker.take(times_of(frames), target.match, target.views[0], target.views[1]);
  target_t said{};
  said.utime = frames.utime();
  said.sequence = sequence_++;
  said.left_frame_utime = frames.frame_utime(Side::kLeft);
  said.right_frame_utime = frames.frame_utime(Side::kRight);
  said.pair_sequence = frames.pair_sequence();
  said.last_seen_utime = report.last_seen_utime.value_or(-1);
  said.status = wire_status(report.status);
  said.name = target.name;
  said.reason = report.reason;
  put(said.position_m, report.estimate.position);
  put(said.covariance_m2, report.estimate.covariance);
  if (report.status != Status::kLost) {
    put(said.velocity_m_s, report.velocity);
    put(said.velocity_covariance_m2_s2, report.velocity_covariance);
  }
  if (!fault) {
    Eigen::Map<Eigen::Vector2d>(said.left_px) = target.match.left_px;
    Eigen::Map<Eigen::Vector2d>(said.right_px) = target.match.right_px;
    said.epipolar_error_px = target.match.point.epipolar_error_px;
    said.occlusion = target.match.occlusion;
  }
  return said;
}

tracker_state_t VisionNode::state_of(const Target& target) const {
  tracker_state_t state{};
  state.utime = target.last.utime;
  state.sequence = target.last.sequence;
  state.value = target.tracker.serialize(target.last.utime);
  const std::vector<double> watched = watch_.serialize();
  state.value.insert(state.value.end(), watched.begin(), watched.end());
  state.num_values = static_cast<int32_t>(state.value.size());
  return state;
}

bool VisionNode::deserialize(const std::vector<std::span<const uint8_t>>& sent) {
  constexpr size_t kWatched = vision::FrozenFrameDetector::kSerializedSize;
  if (sent.size() != targets_.size()) return false;
  vision::FrozenFrameDetector watch;
  std::vector<vision::StereoTracker> trackers;
  for (size_t k = 0; k < sent.size(); ++k) {
    const auto said = decode<tracker_state_t>(sent[k]);
    if (!said || said->sequence != sequence_ + static_cast<int64_t>(k) || said->value.size() < kWatched) return false;
    const std::span<const double> memory = said->value;
    const size_t own = memory.size() - kWatched;
    trackers.push_back(targets_[k].tracker);
    if (!trackers[k].deserialize(said->utime, memory.first(own)) || !watch.deserialize(memory.subspan(own)))
      return false;
  }
  for (size_t k = 0; k < trackers.size(); ++k) targets_[k].tracker = std::move(trackers[k]);
  watch_ = watch;
  sequence_ += sent_per_input();
  return true;
}

Receipt VisionNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel == channel::kVisionDebugRequest) {
    if (const auto request = take<debug_request_t>(bytes)) picture_of_ = request->name;
    return {};
  }
  StereoFrames frames(bytes);
  for (const Side side : kSides) frames.lend(side, buffers_[static_cast<size_t>(index(side))]);
  const Receipt receipt = conclude(frames, out);
  for (const Side side : kSides) buffers_[static_cast<size_t>(index(side))] = frames.buffer(side);
  return receipt;
}

Receipt VisionNode::conclude(StereoFrames& frames, Outbox& out) {
  ++(frames.decoded() ? counters_.received : counters_.refused);
  if (!frames.decoded()) return {};
  if (!plausible_utime(frames.utime())) {
    ++counters_.refused;
    return {};
  }
  const char* fault = fault_of(frames);
  if (fault) ++counters_.refused;
  for (Target& target : targets_) {
    target.last = target_of(target, frames, fault);
    send(out, channel::kTarget, target.last);
    send(out, channel::kTrackerState, state_of(target));
  }
  if (frames.pair_sequence() >= 0) counters_.dropped += pairs_.missing_before(frames.pair_sequence());
  send_debug_picture(frames, out);
  return {Receipt::Effect::kTaken, frames.utime(), frames.pair_sequence()};
}

void VisionNode::send_debug_picture(StereoFrames& frames, Outbox& out) {
  if (picture_of_) {
    pictures_until_ = frames.utime() + kPicturesFor;
    shown_ = *std::exchange(picture_of_, std::nullopt);
  }
  // The time may also jump back, when a log is played again.
  if (frames.utime() > pictures_until_ || frames.utime() < pictures_until_ - kPicturesFor) return;
  std::array<cv::Mat, 2> images;
  for (const Side side : kSides) {
    const auto at = static_cast<size_t>(index(side));
    const cv::Rect whole = targets_.front().tracker.whole_image(side);
    const bool fits = frames.has(side, whole.width, whole.height);
    const cv::Mat* bgr = fits ? frames.pixels(side, whole, codecs_[at]) : nullptr;
    images[at] = bgr ? *bgr : cv::Mat(whole.size(), CV_8UC3, cv::Scalar(0, 0, 0));
  }
  static const std::array kColours{cv::Scalar(0, 255, 0), cv::Scalar(255, 255, 0), cv::Scalar(0, 200, 255),
                                   cv::Scalar(255, 120, 255)};
  std::vector<vision::DebugMarks> marks;
  for (const Target& target : targets_) {
    if (!shown_.empty() && target.name != shown_) continue;
    vision::DebugMarks mark{fmt::format("{} {}: {}", target.name, word_for(target.last.status), target.last.reason),
                            kColours[marks.size() % kColours.size()],
                            {}};
    for (size_t side = 0; side < 2; ++side) {
      mark.sides[side].window = target.views[side].window;
      const int chosen = side == 0 ? target.match.left : target.match.right;
      for (size_t k = 0; k < target.views[side].contours.size(); ++k) {
        const vision::SphereContour& contour = target.views[side].contours[k];
        mark.sides[side].contours.push_back({contour.centre_px, contour.radius_px, static_cast<int>(k) == chosen});
      }
    }
    marks.push_back(std::move(mark));
  }
  const cv::Mat picture = vision::debug_picture(images[0], images[1], marks);
  constexpr int kQuality = 80;
  images_t message;
  message.utime = frames.utime();
  message.n_images = 1;
  message.image_types = {images_t::LEFT};
  image_t& image = message.images.emplace_back();
  image.utime = frames.utime();
  image.width = picture.cols;
  image.height = picture.rows;
  image.row_stride = 0;
  image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
  image.data = codecs_[0].encode_jpeg(picture, kQuality);
  image.size = static_cast<int32_t>(image.data.size());
  image.nmetadata = 0;
  send(out, channel::kVisionDebug, message);
}

std::string VisionNode::state() const {
  if (targets_.front().last.utime == 0) return "waiting";
  std::string text;
  for (const Target& target : targets_) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{} {}", target.name, word_for(target.last.status));
    if (target.last.status != target_t::STATUS_TRACKED) text += ": " + target.last.reason;
  }
  return text;
}

}  // namespace multireach
