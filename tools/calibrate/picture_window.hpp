#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace multireach {

/// Whether windows can be shown on the display that the environment names. Tried in a process of its own, for the
/// window toolkit ends a process that finds no display.
bool windows_can_be_shown();

/// Shows a picture (8-bit BGR) in a window with this title. The user clicks on a point, or draws a rectangle with the
/// mouse, and presses Enter: returns the rectangle, in pixels of the picture, 1 x 1 for a click. Nothing where the user
/// presses Escape or closes the window.
std::optional<cv::Rect> pointed_at(const std::string& title, const cv::Mat& bgr);

}  // namespace multireach
