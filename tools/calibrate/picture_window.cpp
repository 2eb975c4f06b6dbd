#include "tools/calibrate/picture_window.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/highgui.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace multireach {
namespace {

constexpr double kLargest = 1200;  // pixels of a window at first

/// What the mouse has done in the window.
struct Pointing {
  cv::Rect picture;
  std::optional<cv::Point> pressed_at{};
  std::optional<cv::Rect> chosen{};
  bool changed = true;

  void on_mouse(int event, int x, int y) {
    const cv::Point at(std::clamp(x, 0, picture.width - 1), std::clamp(y, 0, picture.height - 1));
    if (event == cv::EVENT_LBUTTONDOWN) pressed_at = at;
    if (!pressed_at) return;
    chosen = cv::Rect(*pressed_at, at) | cv::Rect(*pressed_at, cv::Size(1, 1));
    if (event == cv::EVENT_LBUTTONUP) pressed_at.reset();
    changed = true;
  }
};

/// The picture with what was chosen.
cv::Mat drawn(const cv::Mat& bgr, const std::optional<cv::Rect>& chosen) {
  cv::Mat picture = bgr.clone();
  if (!chosen) return picture;
  const int thick = 1 + std::max(bgr.cols, bgr.rows) / 800;
  for (const auto& [colour, width] : {std::pair(cv::Scalar(0, 0, 0), 3 * thick), {cv::Scalar(255, 255, 255), thick}}) {
    if (chosen->area() > 1) {
      cv::rectangle(picture, *chosen, colour, width);
    } else {
      cv::drawMarker(picture, chosen->tl(), colour, cv::MARKER_CROSS, 20 * thick, width);
    }
  }
  return picture;
}

}  // namespace

bool windows_can_be_shown() {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return false;
  const pid_t child = fork();
  if (child < 0) return false;
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDERR_FILENO);
    try {
      cv::namedWindow("multireach", cv::WINDOW_AUTOSIZE);
    } catch (const cv::Exception&) {
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::optional<cv::Rect> pointed_at(const std::string& title, const cv::Mat& bgr) {
  constexpr int kEnter = 13, kLineFeed = 10, kSpace = 32, kEscape = 27, kWait = 30;  // ms
  Pointing pointing{.picture = {{0, 0}, bgr.size()}};
  cv::namedWindow(title, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO | cv::WINDOW_GUI_NORMAL);
  const double scale = std::min(1.0, kLargest / std::max(bgr.cols, bgr.rows));
  cv::resizeWindow(title, static_cast<int>(scale * bgr.cols), static_cast<int>(scale * bgr.rows));
  cv::setMouseCallback(
      title, [](int event, int x, int y, int, void* data) { static_cast<Pointing*>(data)->on_mouse(event, x, y); },
      &pointing);
  std::optional<cv::Rect> result;
  for (;;) {
    if (std::exchange(pointing.changed, false)) cv::imshow(title, drawn(bgr, pointing.chosen));
    const int key = cv::waitKey(kWait);
    const bool enter = key == kEnter || key == kLineFeed || key == kSpace;
    if (enter && pointing.chosen) {
      result = pointing.chosen;
      break;
    }
    // A window that the user has closed is not visible; imshow() would open it again.
    if (key == kEscape || cv::getWindowProperty(title, cv::WND_PROP_VISIBLE) < 1) break;
  }
  cv::destroyAllWindows();
  return result;
}

}  // namespace multireach
