#pragma once

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/colour/blob.hpp"

namespace multireach {

/// The blobs of an 8-bit mask, the largest first: OpenCV's 8-connected components, without those below `min_area`
/// pixels.
inline std::vector<vision::Blob> blobs_of(const cv::Mat& mask, double min_area) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, statistics, centroids, 8, CV_32S);
  std::vector<vision::Blob> all(static_cast<size_t>(count));
  for (int row = 0; row < labels.rows; ++row) {
    const int* label = labels.ptr<int>(row);
    for (int begin = 0; begin < labels.cols;) {
      int end = begin;
      while (end < labels.cols && label[end] == label[begin]) ++end;
      if (label[begin] > 0) all[static_cast<size_t>(label[begin])].runs.push_back({row, begin, end});
      begin = end;
    }
  }
  std::vector<vision::Blob> blobs;
  for (int k = 1; k < count; ++k) {
    vision::Blob& blob = all[static_cast<size_t>(k)];
    blob.area = statistics.at<int>(k, cv::CC_STAT_AREA);
    blob.box = {statistics.at<int>(k, cv::CC_STAT_LEFT), statistics.at<int>(k, cv::CC_STAT_TOP),
                statistics.at<int>(k, cv::CC_STAT_WIDTH), statistics.at<int>(k, cv::CC_STAT_HEIGHT)};
    blob.centroid = {centroids.at<double>(k, 0), centroids.at<double>(k, 1)};
    const cv::Moments moments = cv::moments(labels == k, true);
    blob.spread << moments.mu20, moments.mu11, moments.mu11, moments.mu02;
    blob.spread /= blob.area;
    if (blob.area >= min_area) blobs.push_back(std::move(blob));
  }
  std::ranges::stable_sort(blobs, std::greater<>(), &vision::Blob::area);
  return blobs;
}

}  // namespace multireach
