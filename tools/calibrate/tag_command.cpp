#include <fmt/format.h>

#include <memory>

#include "runtime/files.hpp"
#include "tools/calibrate/commands.hpp"
#include "vision/fiducial/tag_detector.hpp"

namespace multireach {
namespace {

struct TagPrint {
  int id = -1;
  double size_m = 0;
  std::string output;
};

/// An SVG in millimetres, which every browser prints.
std::string tag_svg(int id, double size_m) {
  const cv::Mat1b cells = vision::tag_cells(id);
  const double cell_mm = 1e3 * size_m / vision::kTagCells, side_mm = cell_mm * cells.cols;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {2} {3}\">\n"
      "<title>AprilTag 36h11, id {4}: the black square is {5} mm wide</title>\n"
      "<rect width=\"{2}\" height=\"{3}\" fill=\"white\"/>\n",
      side_mm, side_mm + cell_mm, cells.cols, cells.rows + 1, id, 1e3 * size_m);
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.cols; ++column) {
      if (cells(row, column)) continue;
      // A cell reaches a little into the next black one, so that no light line shows between them.
      const bool right = column + 1 < cells.cols && !cells(row, column + 1), below = !cells(row + 1, column);
      svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", column, row, right ? 1.02 : 1,
                         below ? 1.02 : 1);
    }
  }
  return svg + fmt::format(
                   "<text x=\"1\" y=\"{}\" font-size=\"0.4\" fill=\"grey\">36h11 id {}, size_m {}: measure the "
                   "black square</text>\n</svg>\n",
                   cells.rows + 0.3, id, size_m);
}

int print_tag(const TagPrint& options) {
  write_text_file(options.output, tag_svg(options.id, options.size_m));
  return 0;
}

}  // namespace

Command tag_command(CommandLine& cli) {
  const auto options = std::make_shared<TagPrint>();
  CommandLine app = cli.subcommand("tag", "an AprilTag of the family 36h11 to print, as SVG in its true size");
  app.option("--id", options->id, "number of the tag, 0 to 586").required().whole(0, vision::kTagIds - 1);
  app.option("--size", options->size_m, "side of the black square, metres").required().finite(1e-3, 10);
  app.option("-o", options->output, "the SVG file; - for standard output").required();
  return {app, [options] { return print_tag(*options); }};
}

}  // namespace multireach
