#pragma once

#include <functional>
#include <memory>
#include <multireach/images_t.hpp>
#include <multireach/practice_scene_t.hpp>
#include <multireach/target_t.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "runtime/robot_config.hpp"
#include "tools/page/arm_motion.hpp"
#include "tools/page/capture_time.hpp"
#include "tools/page/course_folder.hpp"
#include "tools/page/touch.hpp"

namespace multireach {

/// What the steps of the set-up course share.
struct CourseContext {
  CourseFolder& folder;
  const RobotConfig& robot;
  ArmMotion& arm;
  Touch& touch;
  const CaptureTime& capture_time;
  bool practice = false;
  int64_t now_us = 0;     ///< time of this tick
  Outbox* out = nullptr;  ///< for messages

  /// Practice: what the user's hands show the cameras; else nothing.
  void show(int8_t kind, const Eigen::Vector3d& position = Eigen::Vector3d::Zero(),
            const Eigen::Quaterniond& orientation = Eigen::Quaterniond::Identity()) const;
};

/// One step of the set-up course. It gets all messages that any step needs, whether it is being done or not.
class CourseStep {
 public:
  using json = nlohmann::json;

  virtual ~CourseStep() = default;
  virtual const char* name() const = 0;
  /// Whether its result is there, in files.
  virtual bool done() const = 0;
  /// Begins, or begins again where it was left; `request` has what the user told. Throws InputError.
  virtual void begin(CourseContext& context, const json& request) = 0;
  /// Something that the user does in this step, e.g. a click. Throws InputError.
  virtual void act(CourseContext&, const json&) {}
  /// Forgets the result.
  virtual void again(CourseContext& context) = 0;
  /// The user leaves the step.
  virtual void leave(CourseContext&) {}
  virtual void tick(CourseContext&) {}
  /// Whether it does nothing more until it is begun again, e.g. because it has failed.
  virtual bool ended() const { return false; }
  virtual void images(const std::shared_ptr<const images_t>&, CourseContext&) {}
  virtual void target(const target_t&, CourseContext&) {}
  virtual void truth(const target_t&, CourseContext&) {}
  virtual void robot(const JointVector& /*theta*/, int64_t /*utime*/, CourseContext&) {}
  /// What is right or wrong, and what to do; one or two sentences.
  virtual std::string text() const = 0;
  /// Further numbers for the page.
  virtual json details() const { return json::object(); }
};

/// Both images of a message, BGR; empty ones where they are not there or cannot be decoded.
std::array<cv::Mat, 2> decoded_pair(const images_t& images);
/// An image as text that a page shows: data:image/jpeg;base64,...
std::string jpeg_url(const cv::Mat& bgr);

std::unique_ptr<CourseStep> cameras_step();
std::unique_ptr<CourseStep> board_step(const CourseFolder& folder);
std::unique_ptr<CourseStep> object_step(const CourseFolder& folder);
std::unique_ptr<CourseStep> pose_step(const CourseFolder& folder);
std::unique_ptr<CourseStep> check_step(const CourseFolder& folder);
std::unique_ptr<CourseStep> reach_step();

}  // namespace multireach
