#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vision/stereo_vision.hpp"

namespace multireach::bench {

/// Why labels have no right answer.
class Causes {
 public:
  /// Takes a label without a right answer of any of the targets, which look alike.
  void add(const std::vector<vision::StereoVision::Target>& targets, const cv::Point2d& label);
  void add(const Causes& other);
  /// Prints lines of a table: cause, per cent of the labels.
  void print(const std::string& set, const std::string& object, int labels) const;

 private:
  std::map<std::string, int> labels_;
};

}  // namespace multireach::bench
