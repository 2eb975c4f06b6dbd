#pragma once

#include <string>

#include "tools/calibrate/hand_eye.hpp"

namespace multireach {

/// The result in a few lines: how many positions, residuals, the camera's position with standard deviations.
std::string hand_eye_summary(const HandEye& result, const HandEyeOptions& options);
/// left_to_robot for a vision file, with the summary as a comment.
std::string hand_eye_text(const HandEye& result, const HandEyeOptions& options);

}  // namespace multireach
