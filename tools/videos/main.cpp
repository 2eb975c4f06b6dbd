// multireach-videos: what multireach-log import runs for two videos. A program of its own, because OpenCV's videos need
// many packages.
#include <filesystem>
#include <iostream>

#include "runtime/files.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"
#include "tools/log/import/import.hpp"
#include "tools/videos/video_source.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-videos", "Makes a session of two videos, as multireach-log import LEFT RIGHT does.");
  CommandLine& cli = program.cli();
  VideoOptions videos;
  ImportOptions options;
  std::string output;
  cli.option("LEFT", videos.left, "the left camera's video").required();
  cli.option("RIGHT", videos.right, "the right camera's video; its first image is of the same time").required();
  cli.option("-o,--output", output, "log to write").required();
  cli.option("--rate", videos.rate_hz, "images per second (default: as the files say)").finite(0.01, 10000);
  cli.option("--origin-utime", videos.origin_utime, "time of the first images, microseconds").show_default();
  cli.option("--jpeg-quality", videos.jpeg_quality, "JPEG quality of the images; 0 stores them raw")
      .whole(0, 100)
      .show_default();
  return program.run(argc, argv, [&] {
    std::error_code error;
    for (const std::string& video : {videos.left, videos.right}) {
      if (std::filesystem::equivalent(video, output, error))
        throw InputError(output + ": is one of the videos and cannot be written over");
    }
    options.input = videos.left + ", " + videos.right;
    const auto source = open_videos(videos);
    Progress progress;
    const ImportSummary summary = import_images(*source, options, output, [&](double part) { progress.show(part); });
    progress.end();
    std::cout << summary.text();
    return 0;
  });
}
