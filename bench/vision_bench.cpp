// multireach-bench-vision: time to find a coloured ball in rendered, noisy images, compared with a typical OpenCV
// implementation; and time to decode the JPEG images.
#include <benchmark/benchmark.h>
#include <turbojpeg.h>

#include <array>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "camera/rendering/ball_renderer.hpp"
#include "imaging/image_codec.hpp"
#include "numeric/instruction_set.hpp"
#include "runtime/channels.hpp"
#include "vision/colour/find.hpp"
#include "vision/contour/sphere_contour.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

CameraModel camera(int width, int height) {
  const double focal = 500.0 * width / 640;
  return {.width = width, .height = height, .fx = focal, .fy = focal, .cx = width / 2.0, .cy = height / 2.0};
}

/// A ball of 2 cm radius at half a metre in front of a wall with discs of other colours, with noise of three grey
/// levels, seen by a camera `x_m` to the right. Rendered only once, because each benchmark is set up many times.
const cv::Mat& scene(int width, int height, uint64_t stream = 0, double x_m = 0) {
  static std::map<std::tuple<int, int, uint64_t, double>, cv::Mat> drawn;
  cv::Mat& image = drawn[{width, height, stream, x_m}];
  if (image.empty()) {
    const Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d X_WC = X_WL;
    X_WC.translation().x() = x_m;
    const BallRenderer renderer({.noise_grey_levels = 3}, camera(width, height), X_WC, X_WL);
    image = renderer.render(Eigen::Vector3d(0.03, -0.02, 0.5), stream);
  }
  return image;
}

/// A window of a quarter of the width and height, around the ball.
cv::Rect window(int width, int height) {
  return {width * 7 / 16, height * 6 / 16, width / 4, height / 4};
}

vision::ColourClass ball_colours() {
  return {.references = {{220, 40, 110}}, .tolerance = 0.55};
}

void find(benchmark::State& state, const cv::Mat& bgr, const cv::Rect& part) {
  const vision::ColourTable colours(model_of(ball_colours()));
  vision::BlobFinder finder;
  if (finder.find(bgr, part, colours).blobs.size() != 1) state.SkipWithError("not one blob");
  for (auto _ : state) benchmark::DoNotOptimize(finder.find(bgr, part, colours).blobs.data());
}

void find_everywhere(benchmark::State& state, int width, int height, const std::string& instruction_set) {
  select_instruction_set(instruction_set);
  find(state, scene(width, height), {0, 0, width, height});
  select_instruction_set("");
}

void find_in_window(benchmark::State& state, int width, int height) {
  find(state, scene(width, height), window(width, height));
}

/// The usual tutorial recipe: HSV thresholds, morphological opening, contours. One thread.
void opencv_find(benchmark::State& state, int width, int height) {
  cv::setNumThreads(1);
  const cv::Mat bgr = scene(width, height), kernel = cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5});
  cv::Mat hsv, mask;
  std::vector<std::vector<cv::Point>> contours;
  for (auto _ : state) {
    cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
    cv::inRange(hsv, cv::Scalar(155, 120, 40), cv::Scalar(175, 255, 255), mask);
    cv::morphologyEx(mask, mask, cv::MORPH_OPEN, kernel);
    cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
    benchmark::DoNotOptimize(contours.data());
  }
  if (contours.size() != 1) state.SkipWithError("not one contour");
}

void prepare_class(benchmark::State& state, size_t components, size_t background) {
  vision::ColourModel model = model_of(ball_colours());
  model.object.resize(components, model.object[0]);
  for (size_t i = 0; i < background; ++i) {
    model.background.push_back({{0.1 * static_cast<double>(i), 0.1}, 0.02 * Eigen::Matrix2d::Identity()});
  }
  for (auto _ : state) benchmark::DoNotOptimize(vision::ColourTable(model, {1.1, 0.9}));
}

/// Fits the contours of the ball in both JPEGs (q 90), decoded before.
void fit_contours(benchmark::State& state, int width, int height) {
  ImageCodec codec;
  const vision::ColourTable colours(model_of(ball_colours()));
  vision::SphereContourFitter fitter(camera(width, height));
  std::array<cv::Mat, 2> images;
  std::array<vision::Blob, 2> blobs;
  for (size_t k = 0; k < 2; ++k) {
    const std::vector<uint8_t> jpeg = codec.encode_jpeg(scene(width, height, k), 90);
    if (!codec.decode({.width = width, .height = height, .format = PixelFormat::kMjpeg, .data = jpeg}, images[k]))
      state.SkipWithError("not decoded");
    vision::BlobFinder finder;
    const vision::FoundBlobs found = finder.find(images[k], {0, 0, width, height}, colours);
    if (found.blobs.size() != 1) return state.SkipWithError("not one blob");
    blobs[k] = found.blobs[0];
  }
  const cv::Rect whole(0, 0, width, height);
  for (auto _ : state) {
    for (size_t k = 0; k < 2; ++k) {
      if (fitter.fit(images[k], blobs[k], whole, true).kind != vision::SphereContour::Kind::kEdges)
        state.SkipWithError("no contour");
    }
  }
}

/// Decodes two JPEGs of quality 90 in one thread: the share of the vision stage's time spent on decoding.
void decode_jpeg_pair(benchmark::State& state, int width, int height, const cv::Rect& part) {
  ImageCodec codec;
  const std::vector<uint8_t> left = codec.encode_jpeg(scene(width, height, 0), 90),
                             right = codec.encode_jpeg(scene(width, height, 1), 90);
  cv::Mat bgr;
  for (auto _ : state) {
    for (const std::vector<uint8_t>* jpeg : {&left, &right}) {
      const bool read =
          codec.decode({.width = width, .height = height, .format = PixelFormat::kMjpeg, .data = *jpeg}, part, bgr);
      if (!read) state.SkipWithError("not decoded");
    }
  }
}

/// The same two images, decoded by turbojpeg directly.
void turbojpeg_pair(benchmark::State& state, int width, int height) {
  ImageCodec codec;
  const std::vector<uint8_t> left = codec.encode_jpeg(scene(width, height, 0), 90),
                             right = codec.encode_jpeg(scene(width, height, 1), 90);
  cv::Mat bgr(height, width, CV_8UC3);
  tjhandle handle = tjInitDecompress();
  for (auto _ : state) {
    for (const std::vector<uint8_t>* jpeg : {&left, &right}) {
      tjDecompress2(handle, jpeg->data(), jpeg->size(), bgr.data, width, static_cast<int>(bgr.step), height, TJPF_BGR,
                    TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING);
    }
  }
  tjDestroy(handle);
}

/// From a message with two JPEGs to its TARGET, in one thread, as in the live node: while the ball is tracked, only its
/// window is decoded; with `lost`, tracking is reset before every pair and whole images are decoded.
void pair_to_target(benchmark::State& state, int width, int height, bool lost) {
  VisionConfig config;
  config.rig.left = config.rig.right = camera(width, height);
  config.rig.X_RL = config.rig.X_WL = Eigen::Isometry3d::Identity();
  config.rig.X_RL.translation().x() = -0.06;
  vision::TrackerOptions options;
  options.rig = config.rig;
  options.colour.fill(model_of(ball_colours()));
  options.match.radius_m = 0.02;
  config.targets.push_back({"ball", options});
  VisionNode node(config);
  ImageCodec codec;
  images_t pair{};
  pair.n_images = 2;
  pair.image_types = {images_t::LEFT, images_t::RIGHT};
  for (const double x_m : {0.0, config.rig.baseline_m()}) {
    image_t& image = pair.images.emplace_back();
    image.width = width;
    image.height = height;
    image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
    image.data = codec.encode_jpeg(scene(width, height, pair.images.size(), x_m), 90);
    image.size = static_cast<int32_t>(image.data.size());
  }
  int64_t tracked = 0;
  for (auto _ : state) {
    // A pair with a time two seconds earlier resets the tracker.
    pair.utime += lost ? -2000000 : 33333;
    if (pair.utime < 0) pair.utime = int64_t{1} << 50;
    for (image_t& image : pair.images) image.utime = pair.utime;
    state.PauseTiming();
    const std::vector<uint8_t> bytes = *encode(pair);
    state.ResumeTiming();
    Outbox out;
    node.receive(channel::kStereoImages, bytes, out);
    tracked += decode<target_t>(out.at(0).bytes)->status == target_t::STATUS_TRACKED;
  }
  if (tracked != state.iterations()) state.SkipWithError("not tracked");
}

void memory(benchmark::State& state, int width, int height) {
  const cv::Mat bgr = scene(width, height);
  const size_t words = static_cast<size_t>(width) * static_cast<size_t>(height) * 3 / 8;
  const auto* data = reinterpret_cast<const uint64_t*>(bgr.data);
  for (auto _ : state) {
    uint64_t sum = 0;
    for (size_t i = 0; i < words; ++i) sum += data[i];
    benchmark::DoNotOptimize(sum);
  }
}

void register_all() {
  constexpr auto kUnit = benchmark::kMicrosecond;
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(1920, 1080)}) {
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    for (const std::string& name : available_instruction_sets()) {
      benchmark::RegisterBenchmark(("find/" + size + "/" + name).c_str(), find_everywhere, width, height, name)
          ->Unit(kUnit);
    }
    benchmark::RegisterBenchmark(("find_in_window/" + size).c_str(), find_in_window, width, height)->Unit(kUnit);
    benchmark::RegisterBenchmark(("opencv_find/" + size).c_str(), opencv_find, width, height)->Unit(kUnit);
    benchmark::RegisterBenchmark(("turbojpeg_pair/" + size).c_str(), turbojpeg_pair, width, height)->Unit(kUnit);
    const cv::Rect whole(0, 0, width, height), part = window(width, height);
    benchmark::RegisterBenchmark(("decode_jpeg_pair/" + size).c_str(), decode_jpeg_pair, width, height, whole)
        ->Unit(kUnit);
    benchmark::RegisterBenchmark(("decode_jpeg_pair_in_window/" + size).c_str(), decode_jpeg_pair, width, height, part)
        ->Unit(kUnit);
    benchmark::RegisterBenchmark(("pair_to_target/" + size).c_str(), pair_to_target, width, height, false)->Unit(kUnit);
    benchmark::RegisterBenchmark(("pair_to_target_when_lost/" + size).c_str(), pair_to_target, width, height, true)
        ->Unit(kUnit);
    benchmark::RegisterBenchmark(("fit_contours/" + size).c_str(), fit_contours, width, height)->Unit(kUnit);
    benchmark::RegisterBenchmark(("sum_of_bytes/" + size).c_str(), memory, width, height)->Unit(kUnit);
  }
  benchmark::RegisterBenchmark("prepare_class/1+0", prepare_class, 1, 0)->Unit(kUnit);
  benchmark::RegisterBenchmark("prepare_class/3+4", prepare_class, 3, 4)->Unit(kUnit);
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  multireach::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
