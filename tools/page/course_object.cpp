// Step 3 of the set-up course: the user clicks on the object, and sees at once what else has its colours.
#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "runtime/files.hpp"
#include "tools/calibrate/object_colour.hpp"
#include "tools/page/course_step.hpp"
#include "tools/page/job.hpp"
#include "vision/node/colour_config.hpp"

namespace multireach {
namespace {

constexpr double kLargestRadius = 0.5;  // m

/// What was learned from one pair and the clicks on it.
struct ObjectLook {
  std::array<std::optional<ObjectColour>, 2> colours;
  std::string fault;
  cv::Mat picture;
};

ObjectLook look_at_object(const images_t& message, const std::array<std::vector<cv::Point2d>, 2>& clicks) {
  ObjectLook look;
  const auto pair = decoded_pair(message);
  std::array<cv::Mat, 2> shown;
  for (size_t side = 0; side < 2; ++side) {
    const cv::Mat& bgr = pair[side];
    const char* name = side == 0 ? "left" : "right";
    if (bgr.empty()) {
      look.fault = fmt::format("the {} image cannot be decoded", name);
      return look;
    }
    shown[side] = bgr;
    if (clicks[side].empty()) continue;
    std::vector<cv::Point> pixels;
    for (const cv::Point2d& click : clicks[side])
      pixels.emplace_back(cv::saturate_cast<int>(click.x * (bgr.cols - 1)),
                          cv::saturate_cast<int>(click.y * (bgr.rows - 1)));
    const ObjectPicture picture{.bgr = bgr, .region = region_around(bgr, pixels)};
    const ObjectColour object = learn_object(picture);
    if (!object.fault.empty()) look.fault = fmt::format("{} image: {}", name, object.fault);
    if (object.colour.status != vision::LearnedColour::Status::kLearned) continue;
    shown[side] = members_picture(picture, object.colour.model);
    look.colours[side] = object;
  }
  cv::hconcat(shown[0], shown[1], look.picture);
  return look;
}

class ObjectStep : public CourseStep {
 public:
  explicit ObjectStep(const CourseFolder& folder) : done_(CourseFolder::exists(folder.colour())) {}

  const char* name() const override { return "object"; }
  bool done() const override { return done_; }

  void begin(CourseContext& context, const json& request) override {
    if (const auto radius = request.find("radius_m"); radius != request.end()) {
      if (!radius->is_number() || !(*radius >= 0.0 && *radius <= kLargestRadius))
        throw InputError(fmt::format("radius_m: expected 0 (no ball) to {} m", kLargestRadius));
      CourseFolder::Settings settings = context.folder.settings();
      settings.radius_m = radius->get<double>();
      context.folder.change(settings);
      context.folder.write_vision();
    }
    context.show(practice_scene_t::BALL, kPracticePlace);
    seen_.clear();
  }

  void act(CourseContext&, const json& request) override {
    const auto at = [&](const char* key) {
      const auto found = request.find(key);
      const double value = found != request.end() && found->is_number() ? found->get<double>() : -1;
      if (!(value >= 0 && value <= 1)) throw InputError("a click needs u and v, from 0 to 1");
      return value;
    };
    const cv::Point2d click(at("u"), at("v"));
    if (!newest_) throw InputError("there are no images yet");
    if (job_.busy()) throw InputError("one click after the other: the last one is being worked on");
    if (!frozen_) frozen_ = newest_;
    clicks_[request.value("side", "left") == "right" ? 1 : 0].push_back(click);
    job_.start([images = frozen_, clicks = clicks_] { return look_at_object(*images, clicks); });
  }

  void again(CourseContext& context) override {
    CourseFolder::remove(context.folder.colour());
    CourseFolder::remove(context.folder.vision());
    *this = ObjectStep(context.folder);
  }

  void images(const std::shared_ptr<const images_t>& images, CourseContext&) override { newest_ = images; }

  void target(const target_t& target, CourseContext&) override {
    const bool seen = target.status == target_t::STATUS_UNCALIBRATED || target.status == target_t::STATUS_TRACKED;
    seen_ = seen ? "Vision sees it." : "Vision does not see it: " + target.reason + ".";
  }

  void tick(CourseContext& context) override {
    const auto look = job_.take();
    if (!look) return;
    picture_ = look->picture.empty() ? "" : jpeg_url(look->picture);
    fault_ = look->fault;
    warnings_.clear();
    for (size_t side = 0; side < 2; ++side) {
      learned_[side] = look->colours[side].has_value();
      if (!learned_[side]) continue;
      for (const std::string& sentence : look->colours[side]->warnings)
        warnings_ += fmt::format(" {} image: {}.", side == 0 ? "Left" : "Right", sentence);
    }
    if (!fault_.empty()) {  // these clicks lead nowhere
      clicks_ = {};
      frozen_.reset();
      return;
    }
    if (!learned_[0] || !learned_[1]) return;
    write_text_file(context.folder.colour(),
                    colour_text({look->colours[0]->colour.model, look->colours[1]->colour.model}));
    context.folder.write_vision();
    done_ = true;
  }

  std::string text() const override {
    if (job_.busy()) return "Learning the colours.";
    if (!fault_.empty())
      return "That did not work: " + fault_ + ". Click again, on another part of the object or in other light.";
    if (done_)
      return "The colours are learned: what is not dark grey below has them." + warnings_ + " " +
             (seen_.empty() ? "Vision starts." : seen_);
    if (learned_[0] || learned_[1])
      return fmt::format("Now click on the object in the {} image.{}", learned_[0] ? "right" : "left", warnings_);
    return "Put the object where both cameras see it, and click on it in the left and in the right image.";
  }

  json details() const override { return {{"picture", picture_}, {"learned", learned_}}; }

 private:
  static inline const Eigen::Vector3d kPracticePlace{0.10, -0.12, 0.10};

  bool done_ = false;
  std::shared_ptr<const images_t> newest_, frozen_;
  std::array<std::vector<cv::Point2d>, 2> clicks_;
  std::array<bool, 2> learned_{};
  std::string fault_, warnings_, picture_, seen_;
  Job<ObjectLook> job_;
};

}  // namespace

std::unique_ptr<CourseStep> object_step(const CourseFolder& folder) {
  return std::make_unique<ObjectStep>(folder);
}

}  // namespace multireach
