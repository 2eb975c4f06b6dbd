#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "imaging/image_codec.hpp"
#include "python/message_objects.hpp"
#include "runtime/image_file.hpp"
#include "vision/node/stereo_frames.hpp"
#include "vision/node/vision_config.hpp"
#include "vision/reported_covariance.hpp"
#include "vision/tag_vision.hpp"

namespace multireach::python {
namespace {

using Path = std::filesystem::path;
using Status = vision::TargetTrack::Status;

/// The image in an array of shape (height, width, 3), uint8, BGR; the pixels are not copied.
cv::Mat image_of(const py::array& array, const std::string& name) {
  if (!py::dtype::of<uint8_t>().is(array.dtype()) || array.ndim() != 3 || array.shape(2) != 3 ||
      array.strides(2) != 1 || array.strides(1) != 3 || array.strides(0) < 3 * array.shape(1))
    throw std::invalid_argument(
        name + ": expected an array of shape (height, width, 3), uint8, blue green red, whose rows are contiguous");
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), CV_8UC3, const_cast<void*>(array.data()),
          static_cast<size_t>(array.strides(0))};
}

/// An array that holds on to the image's pixels.
py::array_t<uint8_t> array_of_image(const cv::Mat& bgr) {
  const py::capsule owner(new cv::Mat(bgr), [](void* image) { delete static_cast<cv::Mat*>(image); });
  return {
      {bgr.rows, bgr.cols, 3}, {static_cast<py::ssize_t>(bgr.step), py::ssize_t{3}, py::ssize_t{1}}, bgr.data, owner};
}

/// What the newest pair shows of one target.
struct Seen {
  std::string name, reason;
  Status status;
  vision::PositionEstimate estimate;
  Eigen::Vector3d velocity;
  std::optional<Eigen::Quaterniond> R_WT;
  Eigen::Vector2d left_px, right_px;
  double occlusion, epipolar_error_px;
  std::optional<int64_t> last_seen_utime;
  bool ambiguous = false;
};

const char* word_for(const Seen& seen) {
  const Status status = seen.status;
  if (seen.ambiguous) return "ambiguous";
  return status == Status::kTracked ? "tracked" : status == Status::kCoasting ? "coasting" : "lost";
}

class Vision {
 public:
  explicit Vision(const Path& file) : config_(VisionConfig::load(file.string())) {
    std::vector<vision::TrackerOptions> coloured;
    for (const auto& target : config_.targets) coloured.push_back(target.options);
    if (!coloured.empty()) coloured_.emplace(coloured);
    std::vector<vision::TagOptions> tags;
    for (const auto& tag : config_.tags) tags.push_back(tag.options);
    if (!tags.empty()) tags_.emplace(tags);
  }

  std::vector<Seen> update(const py::array& left, const py::array& right, int64_t utime,
                           std::optional<int64_t> left_utime, std::optional<int64_t> right_utime,
                           bool chroma_subsampled) {
    for (const int64_t time : {utime, left_utime.value_or(utime), right_utime.value_or(utime)}) {
      constexpr int64_t kMost = int64_t{1} << 60;  // so that differences do not overflow
      if (time < -kMost || time > kMost) throw py::value_error("times: expected microseconds, at most 2^60");
    }
    const cv::Mat left_bgr = image_of(left, "left"), right_bgr = image_of(right, "right");
    vision::DecodedImages images({utime, left_utime.value_or(utime), right_utime.value_or(utime)}, left_bgr, right_bgr,
                                 chroma_subsampled);
    const py::gil_scoped_release release;
    const char* fault = coloured_ ? coloured_->update(images) : nullptr;
    const char* tag_fault = tags_ ? tags_->update(images) : nullptr;
    std::vector<Seen> seen;
    for (size_t i = 0; i < config_.targets.size(); ++i) {
      const auto& target = coloured_->targets()[i];
      seen.push_back(report(config_.targets[i].name, target.report, fault));
      seen.back().left_px = target.match.left_px;
      seen.back().right_px = target.match.right_px;
      seen.back().occlusion = target.match.occlusion;
      seen.back().epipolar_error_px = target.match.point.epipolar_error_px;
    }
    for (size_t i = 0; i < config_.tags.size(); ++i) {
      const auto& target = tags_->targets()[i];
      seen.push_back(report(config_.tags[i].name, target.report, tag_fault));
      seen.back().R_WT = target.report.R_WT;
      seen.back().left_px = target.match.centre_px[0];
      seen.back().right_px = target.match.centre_px[1];
      seen.back().epipolar_error_px = target.match.epipolar_error_px;
    }
    return seen;
  }

  void restart() {
    if (coloured_) coloured_->restart();
    if (tags_) tags_->restart();
  }
  const StereoRig& rig() const { return config_.rig; }

 private:
  static Seen report(const std::string& name, const vision::TargetReport& report, const char* fault) {
    return {
        name, fault ? fault : report.reason, report.status,   report.estimate, report.velocity, {}, {0, 0}, {0, 0}, 0,
        0,    report.last_seen_utime,        report.ambiguous};
  }

  VisionConfig config_;
  std::optional<vision::StereoVision> coloured_;
  std::optional<vision::TagVision> tags_;
};

py::object decoded_image(StereoFrames& frames, Side side, ImageCodec& codec) {
  if (frames.frame_utime(side) < 0) return py::none();
  const cv::Mat* bgr = frames.pixels(side, cv::Rect(0, 0, 1 << 15, 1 << 15), codec);
  return bgr ? array_of_image(bgr->clone()) : py::object(py::none());
}

}  // namespace

void bind_vision(py::module_& module) {
  py::class_<Seen>(module, "TargetReport", "What vision knows of one target after a pair.")
      .def_readonly("name", &Seen::name)
      .def_property_readonly(
          "status", [](const Seen& seen) { return word_for(seen); },
          "tracked, coasting (expected, not seen), lost or ambiguous (several things could be it); with the last two "
          "the "
          "position means nothing.")
      .def_readonly("reason", &Seen::reason, "Why the target has this status.")
      .def_property_readonly(
          "position", [](const Seen& seen) { return array_of(seen.estimate.position); }, "m, in W.")
      .def_property_readonly(
          "covariance", [](const Seen& seen) { return matrix_of(seen.estimate.covariance); }, "m^2, in W.")
      .def_property_readonly(
          "velocity", [](const Seen& seen) { return array_of(seen.velocity); }, "m/s, in W.")
      .def_property_readonly(
          "orientation",
          [](const Seen& seen) -> py::object {
            return seen.R_WT ? py::object(matrix_of(seen.R_WT->toRotationMatrix())) : py::none();
          },
          "Of a tag: rotation matrix from its frame to W; None where it is not known.")
      .def_property_readonly(
          "left_px", [](const Seen& seen) { return array_of(seen.left_px); }, "Its centre, pixels, distorted.")
      .def_property_readonly("right_px", [](const Seen& seen) { return array_of(seen.right_px); })
      .def_readonly("occlusion", &Seen::occlusion, "Share that is occluded or cut off, 0 to 1.")
      .def_readonly("epipolar_error_px", &Seen::epipolar_error_px)
      .def_readonly("last_seen_utime", &Seen::last_seen_utime)
      .def("__repr__",
           [](const Seen& seen) { return "<multireach.TargetReport " + seen.name + ": " + word_for(seen) + ">"; });
  py::class_<Vision>(module, "Vision", R"(Tracks the targets of a vision.yaml through stereo pairs.

Images are arrays of shape (height, width, 3), uint8, blue green red; their pixels are not copied.)")
      .def(py::init<const Path&>(), py::arg("path"))
      .def("update", &Vision::update, py::arg("left"), py::arg("right"), py::arg("utime"),
           py::arg("left_utime") = py::none(), py::arg("right_utime") = py::none(),
           py::arg("chroma_subsampled") = false,
           R"(Takes the next pair and returns a TargetReport for each target.

utime: capture time of the pair, microseconds, newer than that of the pair before; left_utime, right_utime: of each image.
chroma_subsampled: the images were decoded from JPEGs with 4:2:0 or 4:2:2 chroma, as those of most cameras: the covariance then is that of their errors.)")
      .def("restart", &Vision::restart, "Forgets all pairs.")
      .def_property_readonly(
          "image_size",
          [](const Vision& vision) { return std::pair(vision.rig().left.width, vision.rig().left.height); },
          "Width and height of the left camera's images, pixels.")
      .def(
          "project",
          [](const Vision& vision, const Doubles& position) {
            const StereoRig& rig = vision.rig();
            const Eigen::Vector3d p_L = rig.X_WL.inverse() * vector3_of(position, "position");
            return py::make_tuple(array_of(rig.left.project(p_L)), array_of(rig.right.project(rig.X_RL * p_L)));
          },
          py::arg("position"), "Where both cameras see a position (m, in W), pixels: (left, right).")
      .def(
          "triangulate",
          [](const Vision& vision, const Doubles& left_px, const Doubles& right_px, double sigma_px) -> py::object {
            const auto measured = [&](const CameraModel& camera, const Doubles& px, const char* name) {
              if (px.size() != 2) throw std::invalid_argument(std::string(name) + ": expected 2 numbers, pixels");
              return vision::RayMeasurement{camera.ray({px.data()[0], px.data()[1]}),
                                            vision::ray_covariance(camera, sigma_px)};
            };
            const StereoRig& rig = vision.rig();
            const auto point = vision::triangulate(rig, measured(rig.left, left_px, "left_px"),
                                                   measured(rig.right, right_px, "right_px"));
            if (!point) return py::none();
            return py::make_tuple(array_of(point->p_W),
                                  matrix_of(vision::reported_covariance(rig, {point->p_W, point->covariance})));
          },
          py::arg("left_px"), py::arg("right_px"), py::arg("sigma_px") = 0.5,
          "(position, covariance) in W, m and m^2, of a point seen at these pixels; None when the rays do not meet.");
  module.def(
      "read_image", [](const Path& path) { return array_of_image(read_image(path.string())); }, py::arg("path"),
      "A PNG or JPEG file as an array of shape (height, width, 3), uint8, blue green red.");
  module.def(
      "images_of",
      [](const py::buffer& data) {
        const py::buffer_info info = data.request();
        StereoFrames frames(
            std::span(static_cast<const uint8_t*>(info.ptr), static_cast<size_t>(info.size * info.itemsize)));
        if (!frames.is_valid()) throw std::invalid_argument("images_of: expected the bytes of an images_t message");
        ImageCodec codec;
        const py::object left = decoded_image(frames, Side::kLeft, codec),
                         right = decoded_image(frames, Side::kRight, codec);
        return py::make_tuple(left, right);
      },
      py::arg("data"),
      "The left and right image of a STEREO_IMAGES message (its bytes), decoded; None where there is none.");
}

}  // namespace multireach::python
