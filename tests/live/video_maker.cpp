// Makes videos and images whose frames can be distinguished, and identifies their frames.
#include <cstdlib>
#include <iostream>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace {

constexpr int kStep = 8;  // grey levels from one frame to the next, more than JPEG changes

cv::Mat frame(int number, int width, int height) {
  const int grey = number * kStep % 256;
  return {height, width, CV_8UC3, cv::Scalar(grey, grey, grey)};
}

int usage() {
  std::cerr << "multireach-test-video avi FILE FRAMES WIDTH HEIGHT | jpeg FILE NUMBER WIDTH HEIGHT | tell FILE...\n";
  return 2;
}

int make(const std::string& what, const std::string& file, int number, int width, int height) {
  if (what == "jpeg") return cv::imwrite(file, frame(number, width, height)) ? 0 : 1;
  if (what != "avi") return usage();
  cv::VideoWriter video(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, {width, height});
  for (int k = 0; k < number; ++k) video.write(frame(k, width, height));
  return video.isOpened() ? 0 : 1;
}

/// The number of each file's frame, modulo 32.
int tell(int count, char** files) {
  for (int i = 0; i < count; ++i) {
    const cv::Mat image = cv::imread(files[i]);
    if (image.empty()) return 1;
    std::cout << cvRound(cv::mean(image)[0] / kStep) << "\n";
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "tell") return tell(argc - 2, argv + 2);
  return argc == 6 ? make(what, argv[2], std::atoi(argv[3]), std::atoi(argv[4]), std::atoi(argv[5])) : usage();
}
