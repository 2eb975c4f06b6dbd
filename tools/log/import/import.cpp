#include "tools/log/import/import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <deque>

#include "camera/pairing/frame_pairing.hpp"
#include "camera/pairing/stereo_message.hpp"
#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/node.hpp"

namespace multireach {
namespace {

constexpr double kListing = 0.2;  // share of the progress that the list of the images takes

using Pair = std::pair<ListedImage, ListedImage>;

int64_t median(std::vector<int64_t> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median time between images of one camera; of both cameras, the shorter one.
int64_t period_of(const std::vector<ListedImage>& sorted) {
  std::optional<int64_t> period;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    std::vector<int64_t> intervals;
    std::optional<int64_t> before;
    for (const ListedImage& image : sorted) {
      if (image.side != side) continue;
      if (before && image.utime > *before) intervals.push_back(image.utime - *before);
      before = image.utime;
    }
    if (!intervals.empty()) period = std::min(period.value_or(INT64_MAX), median(intervals));
  }
  constexpr int64_t kAnyRate = 1000000;  // us; for a single pair
  return period.value_or(kAnyRate);
}

/// Pairs images by time as a live camera does.
std::vector<Pair> paired(const std::vector<ListedImage>& sorted, int64_t period_us, int64_t max_skew_us,
                         int64_t& unpaired) {
  FramePairing pairing(period_us, max_skew_us);
  std::array<std::deque<ListedImage>, 2> waiting;  // the images that the pairing may hold, by side
  std::vector<Pair> pairs;
  const auto taken = [&](Side side, int64_t utime) {
    std::deque<ListedImage>& images = waiting[index(side)];
    while (images.front().utime != utime) images.pop_front();
    return images.front();
  };
  // A last image of each side, later than all, ends the wait for images that could be nearer.
  const int64_t end = sorted.back().utime + 2 * (max_skew_us + 8 * period_us);
  std::vector<ListedImage> all = sorted;
  all.push_back({end, Side::kLeft, 0});
  all.push_back({end, Side::kRight, 0});
  for (const ListedImage& image : all) {
    waiting[index(image.side)].push_back(image);
    for (const FramePairing::Pair& pair : pairing.add(image.side, Frame{.utime = image.utime})) {
      if (pair.left.utime < end && pair.right.utime < end)
        pairs.emplace_back(taken(Side::kLeft, pair.left.utime), taken(Side::kRight, pair.right.utime));
    }
  }
  unpaired = static_cast<int64_t>(sorted.size()) - 2 * static_cast<int64_t>(pairs.size());
  return pairs;
}

std::string named(const ImportOptions& options, const char* side, const std::string& name) {
  return name.empty() ? options.input + ": the " + side + " camera" : options.input + ": '" + name + "'";
}

std::vector<ListedImage> listed(ImageSource& source, const ImportOptions& options,
                                const ImageSource::Progress& progress) {
  std::vector<ListedImage> images = source.list(progress);
  for (const auto& [side, word, name] :
       {std::tuple(Side::kLeft, "left", options.left), {Side::kRight, "right", options.right}}) {
    if (std::ranges::none_of(images, [side = side](const ListedImage& image) { return image.side == side; }))
      throw InputError(named(options, word, name) + " has no image; expected at least one");
  }
  for (const ListedImage& image : images) {
    if (!plausible_utime(image.utime))
      throw InputError(fmt::format("{}: an image has the time {} us; expected one from 0 to 36000 years after 1970",
                                   options.input, image.utime));
  }
  std::ranges::stable_sort(images, {}, [](const ListedImage& image) { return image.utime; });
  return images;
}

}  // namespace

std::string ImportSummary::text() const {
  std::string text =
      fmt::format("{} pairs of {} x {} pixels in {:.2f} s, {:.1f} ms apart; {} images without a partner\n", pairs,
                  width, height, span_s, 1e-3 * static_cast<double>(period_us), unpaired);
  text += fmt::format("right image after the left: median {:.2f} ms, at most {:.2f} ms apart\n",
                      1e-3 * static_cast<double>(median_skew_us), 1e-3 * static_cast<double>(max_skew_us));
  return text;
}

ImportSummary import_images(const ImportOptions& options, const std::string& output,
                            const ImageSource::Progress& progress) {
  return import_images(*open_image_source(options), options, output, progress);
}

ImportSummary import_images(ImageSource& source, const ImportOptions& options, const std::string& output,
                            const ImageSource::Progress& progress) {
  const std::vector<ListedImage> images = listed(source, options, [&](double part) { progress(kListing * part); });
  ImportSummary summary;
  summary.period_us = period_of(images);
  const int64_t max_skew_us =
      options.max_skew_s ? static_cast<int64_t>(std::llround(*options.max_skew_s * 1e6)) : summary.period_us / 2;
  const std::vector<Pair> pairs = paired(images, summary.period_us, max_skew_us, summary.unpaired);
  if (pairs.empty())
    throw InputError(
        fmt::format("{}: no left and right image are at most {} s apart; expected cameras with the same "
                    "clock, or a larger --max-skew",
                    options.input, 1e-6 * static_cast<double>(max_skew_us)));
  LogWriter log(output);
  std::vector<int64_t> skews;
  for (const auto& [left, right] : pairs) {
    Frame left_frame = source.read(left), right_frame = source.read(right);
    if (summary.pairs == 0) {
      summary.width = left_frame.width;
      summary.height = left_frame.height;
    }
    skews.push_back(right.utime - left.utime);
    summary.max_skew_us = std::max(summary.max_skew_us, std::abs(skews.back()));
    const auto bytes =
        encode(stereo_message(left.utime, std::move(left_frame), std::move(right_frame), summary.pairs++));
    if (!bytes) throw InputError(options.input + ": a pair is too large for a message; expected less than 2 GB");
    log.write(left.utime, channel::kStereoImages, *bytes);
    progress(kListing + (1 - kListing) * static_cast<double>(summary.pairs) / static_cast<double>(pairs.size()));
  }
  log.close();
  summary.median_skew_us = median(skews);
  summary.span_s = 1e-6 * static_cast<double>(pairs.back().first.utime - pairs.front().first.utime);
  summary.warning = source.warning();
  return summary;
}

}  // namespace multireach
