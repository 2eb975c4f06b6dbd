// Step 2 of the set-up course: the cameras are calibrated with a chessboard that the user moves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "imaging/image_codec.hpp"
#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"
#include "runtime/camera_files.hpp"
#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "tools/calibrate/board_images.hpp"
#include "tools/calibrate/camera_file_texts.hpp"
#include "tools/page/course_step.hpp"
#include "tools/page/job.hpp"

namespace multireach {
namespace {

// When the calibration is good enough to stop.
constexpr size_t kLeastPairs = 12, kFirstCalibration = 8;
constexpr double kLeastCoverage = 0.6;  // of the fields of both images
constexpr double kMostSigma = 0.006;    // of a focal length, relative
constexpr double kMostRms = 0.6;        // px, of images of 640 pixels and less; in proportion for larger ones
constexpr double kStill = 0.4;          // px: a board whose corners move less from one look to the next is at rest
constexpr int kStillLooks = 2;          // so often in succession
constexpr double kNewPose = 0.035;      // of the image's width: mean distance of the corners from those of each picture
constexpr int kSizeVotes = 2;           // looks that must agree on the board's size

/// What was found in one pair of images.
struct BoardLook {
  cv::Size image_size, board_size;
  std::optional<Corners> left, right;
  std::array<cv::Mat, 2> images;
};

cv::Mat grey_of(const cv::Mat& bgr) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

BoardLook look_for_board(const images_t& message, Board board) {
  BoardLook look;
  look.images = decoded_pair(message);
  if (look.images[0].empty() || look.images[1].empty() || look.images[0].size() != look.images[1].size()) return look;
  look.image_size = look.images[0].size();
  const cv::Mat left = grey_of(look.images[0]), right = grey_of(look.images[1]);
  if (board.columns == 0) {
    std::optional<cv::Size> size;
    try {
      size = find_board_size(left, right);
    } catch (const cv::Exception&) {  // OpenCV's search fails on some images
    }
    if (!size) return look;
    look.board_size = *size;
    board.columns = size->width;
    board.rows = size->height;
  }
  look.left = find_board(left, board);
  look.right = find_board(right, board);
  if (look.left && look.right) match_corner_order(board, *look.left, *look.right);
  return look;
}

double mean_distance(const Corners& a, const Corners& b) {
  if (a.size() != b.size()) return 1e9;
  double straight = 0, turned = 0;  // which end comes first may vary
  for (size_t k = 0; k < a.size(); ++k) {
    straight += cv::norm(a[k] - b[k]);
    turned += cv::norm(a[k] - b[b.size() - 1 - k]);
  }
  return std::min(straight, turned) / static_cast<double>(a.size());
}

struct Calibrated {
  std::optional<StereoCalibration> calibration;
  std::string fault;
};

Calibrated calibrated(const std::vector<BoardPair>& pairs, const Board& board, cv::Size size) {
  try {
    // Without k3, which a dozen pairs do not determine.
    Calibrated result{calibrate(pairs, board, size, Lens::kRadtan, true), {}};
    check_rig(result.calibration->rig, "the pictures");
    return result;
  } catch (const std::exception& fault) {
    return {std::nullopt, fault.what()};
  }
}

/// Practice: poses of the board in the left camera's frame, tilted, all over the images.
struct BoardPose {
  Eigen::Vector3d centre;
  Eigen::Quaterniond orientation;
};
BoardPose practice_pose(int index) {
  // A grid of positions in the image, each time at another distance, and tilts that differ.
  static constexpr std::array<std::array<double, 2>, 9> kGrid{
      {{0, 0}, {-1, -1}, {1, 1}, {1, -1}, {-1, 1}, {0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
  const CounterRandom random(17, static_cast<uint64_t>(index));
  const auto& at = kGrid[static_cast<size_t>(index) % kGrid.size()];
  const double z = random.uniform(0, 0.42, 0.6);
  const double room_x = std::max(0.0, 0.46 * z - 0.14), room_y = std::max(0.0, 0.36 * z - 0.1);
  const Eigen::Matrix3d R =
      rotation_from_rpy({random.uniform(1, -0.5, 0.5), random.uniform(2, -0.5, 0.5), random.uniform(3, -0.3, 0.3)});
  return {Eigen::Vector3d(0.03 + at[0] * room_x, at[1] * room_y, z), Eigen::Quaterniond(R)};
}

class BoardStep : public CourseStep {
 public:
  explicit BoardStep(const CourseFolder& folder) : done_(CourseFolder::exists(folder.stereo())) {}

  const char* name() const override { return "board"; }
  bool done() const override { return done_; }

  void begin(CourseContext& context, const json& request) override {
    CourseFolder::Settings settings = context.folder.settings();
    if (const auto square = request.find("square_m"); square != request.end()) {
      if (!square->is_number() || !(*square > 1e-3 && *square < 1)) throw InputError("square_m: expected 0.001 to 1");
      if (settings.square_m != square->get<double>()) {
        settings.square_m = square->get<double>();
        context.folder.change(settings);
      }
    }
    board_ = {settings.columns, settings.rows, settings.square_m};
    active_ = !done_;
    next_practice_pose(context);
    if (pairs_.empty() && settings.columns > 0 && CourseFolder::exists(context.folder.boards() + "/left000.png"))
      read_job_.start([folder = context.folder.boards(), board = board_] {
        return find_boards(folder + "/left*.png", folder + "/right*.png", board, [](double) {});
      });
  }

  void again(CourseContext& context) override {
    for (const std::string& file : {context.folder.vision(), context.folder.stereo()}) CourseFolder::remove(file);
    CourseFolder::remove(context.folder.boards());
    CourseFolder::Settings settings = context.folder.settings();
    settings.columns = settings.rows = 0;
    context.folder.change(settings);
    context.folder = CourseFolder(context.folder.path());
    *this = BoardStep(context.folder);
  }

  void leave(CourseContext&) override { active_ = false; }

  void images(const std::shared_ptr<const images_t>& images, CourseContext&) override {
    if (!active_ || look_job_.busy() || calibrate_job_.busy() || read_job_.busy()) return;
    look_job_.start([images, board = board_] { return look_for_board(*images, board); });
  }

  void tick(CourseContext& context) override {
    if (read_job_.busy()) take_up_pictures();
    if (calibrate_job_.busy()) take_calibration(context);
    const auto look = look_job_.take();
    if (look && active_) take_look(*look, context);
  }

  std::string text() const override {
    if (done_) return fmt::format("The cameras are calibrated{}.", result_.empty() ? "" : ": " + result_);
    if (read_job_.busy()) return "Reading the pictures that were taken before.";
    if (!active_) return "Print a chessboard, glue it to something flat, measure the side of a square, and begin.";
    const std::string count = fmt::format("{} pictures of {} or more. ", pairs_.size(), kLeastPairs);
    if (calibrate_job_.busy()) return count + "Calibrating.";
    if (!seen_[0] && !seen_[1])
      return count + "No camera sees the whole board: hold it so that both do, without fingers on it.";
    if (!seen_[0] || !seen_[1])
      return count + fmt::format("The {} camera does not see the whole board.", seen_[0] ? "right" : "left");
    if (board_.columns == 0) return count + "A board is seen; hold it still until its size is certain.";
    if (taken_now_)
      return count + "Taken. Now elsewhere: where the map is empty, tilted in another way, nearer or further.";
    if (still_ == 0) return count + "Hold the board still.";
    return count + (missing_.empty() ? "Go on: tilted in another way." : missing_);
  }

  json details() const override {
    json sides = json::array();
    for (const bool right : {false, true}) {
      std::vector<Corners> all;
      for (const BoardPair& pair : pairs_) all.push_back(right ? pair.right : pair.left);
      json corners = json::array();
      if (image_size_.width > 0 && live_) {
        for (const cv::Point2f& corner : right ? live_->right : live_->left)
          corners.push_back({std::round(1e3 * corner.x / static_cast<float>(image_size_.width)) / 1e3,
                             std::round(1e3 * corner.y / static_cast<float>(image_size_.height)) / 1e3});
      }
      const auto fields = image_size_.width > 0 ? covered_fields(all, image_size_) : std::set<int>{};
      sides.push_back({{"fields", fields}, {"corners", corners}});
    }
    return {{"pictures", pairs_.size()},
            {"needed", kLeastPairs},
            {"columns", kFieldColumns},
            {"rows", kFieldRows},
            {"pattern", board_.columns > 0 ? fmt::format("{}x{}", board_.columns, board_.rows) : ""},
            {"square_m", board_.square_m},
            {"result", result_},
            {"sides", sides}};
  }

 private:
  void next_practice_pose(CourseContext& context) {
    if (!active_) return;
    const BoardPose pose = practice_pose(shown_++);
    looks_ = 0;
    context.show(practice_scene_t::BOARD, pose.centre, pose.orientation);
  }

  /// Pictures of an earlier session.
  void take_up_pictures() {
    try {
      auto read = read_job_.take();
      if (!read) return;
      pairs_ = read->pairs;
      next_picture_ = read->left_files.size();
      image_size_ = read->size;
    } catch (const std::exception&) {
      pairs_.clear();
    }
  }

  void take_look(const BoardLook& look, CourseContext& context) {
    seen_ = {look.left.has_value(), look.right.has_value()};
    image_size_ = look.image_size;
    if (++looks_ > kMostLooks) next_practice_pose(context);
    if (!look.left || !look.right) {
      still_ = 0;
      live_.reset();
      return;
    }
    if (board_.columns == 0) {
      votes_ = look.board_size == vote_ ? votes_ + 1 : 1;
      vote_ = look.board_size;
      if (votes_ < kSizeVotes) return;
      CourseFolder::Settings settings = context.folder.settings();
      settings.columns = board_.columns = vote_.width;
      settings.rows = board_.rows = vote_.height;
      context.folder.change(settings);
    }
    const BoardPair pair{*look.left, *look.right};
    const double moved =
        live_ ? std::max(mean_distance(live_->left, pair.left), mean_distance(live_->right, pair.right)) : 1e9;
    still_ = moved < kStill ? still_ + 1 : 0;
    live_ = pair;
    const bool fresh = std::ranges::all_of(pairs_, [&](const BoardPair& taken) {
      return mean_distance(taken.left, pair.left) > kNewPose * image_size_.width;
    });
    if (fresh) taken_now_ = false;
    if (still_ < kStillLooks || !fresh) return;
    take_picture(look, pair, context);
  }

  void take_picture(const BoardLook& look, const BoardPair& pair, CourseContext& context) {
    for (size_t side = 0; side < 2; ++side) {
      const std::string path =
          fmt::format("{}/{}{:03}.png", context.folder.boards(), side == 0 ? "left" : "right", next_picture_);
      const std::vector<uint8_t> png = encode_png(look.images[side]);
      OutputFile file(path);
      file.write(png);
      file.finish();
    }
    ++next_picture_;
    pairs_.push_back(pair);
    taken_now_ = true;
    still_ = 0;
    if (pairs_.size() >= kFirstCalibration)
      calibrate_job_.start(
          [pairs = pairs_, board = board_, size = image_size_] { return calibrated(pairs, board, size); });
    next_practice_pose(context);
  }

  void take_calibration(CourseContext& context) {
    const auto result = calibrate_job_.take();
    if (!result) return;
    if (!result->calibration) {
      missing_ = "Not good enough yet: " + result->fault + ".";
      return;
    }
    const StereoCalibration& found = *result->calibration;
    const double sigma =
        std::max(found.left_fx_sigma_px / found.rig.left.fx, found.right_fx_sigma_px / found.rig.right.fx);
    const double most_rms = kMostRms * std::max(1.0, image_size_.width / 640.0);
    result_ = fmt::format("{} pictures, residuals {:.2f} px, focal lengths known to {:.2f} %, baseline {:.1f} mm",
                          pairs_.size(), found.stereo_rms_px, 100 * sigma, 1e3 * found.rig.baseline_m());
    missing_.clear();
    if (found.stereo_rms_px > most_rms)
      missing_ = fmt::format("The residuals are {:.2f} px, not yet below {:.2f}: is the board flat, and held still?",
                             found.stereo_rms_px, most_rms);
    if (sigma > kMostSigma)
      missing_ = fmt::format("The focal lengths are known to {:.2f} % only: tilt the board more.", 100 * sigma);
    for (const bool right : {false, true}) {
      std::vector<Corners> all;
      for (const BoardPair& pair : pairs_) all.push_back(right ? pair.right : pair.left);
      if (coverage(all, image_size_) < kLeastCoverage)
        missing_ =
            fmt::format("Parts of the {} image are still empty: hold the board there.", right ? "right" : "left");
    }
    if (pairs_.size() < kLeastPairs || !missing_.empty()) return;
    write_text_file(context.folder.stereo(), camera_file_texts(found.rig, CameraFormat::kVision).at(0));
    context.folder.write_vision();
    done_ = true;
    active_ = false;
    context.show(practice_scene_t::EMPTY);
  }

  static constexpr int kMostLooks = 12;  // practice: after so many without a picture, the board goes on

  bool done_ = false, active_ = false, taken_now_ = false;
  Board board_{0, 0, 0.025};
  std::array<bool, 2> seen_{};
  cv::Size image_size_, vote_;
  int votes_ = 0, still_ = 0, looks_ = 0, shown_ = 0;
  size_t next_picture_ = 0;
  std::optional<BoardPair> live_;
  std::vector<BoardPair> pairs_;
  std::string missing_, result_;
  Job<BoardLook> look_job_;
  Job<Calibrated> calibrate_job_;
  Job<BoardImages> read_job_;
};

}  // namespace

std::unique_ptr<CourseStep> board_step(const CourseFolder& folder) {
  return std::make_unique<BoardStep>(folder);
}

}  // namespace multireach
