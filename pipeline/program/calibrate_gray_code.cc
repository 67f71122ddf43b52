// lamella calibrate gray-code-patterns and gray-code: which point of a projector or panel every
// pixel of a camera sees.
#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/gray_code_photos.h"
#include "pipeline/program/calibrate.h"

namespace lamella {
namespace {

constexpr int kMostScreenPx = 1 << 14;  // of a side

void AddScreen(CLI::App& verb, GrayCodePatterns& patterns) {
  verb.add_option("--width-px", patterns.width_px, "of the projector or panel")
      ->required()
      ->check(CLI::Range(1, kMostScreenPx));
  verb.add_option("--height-px", patterns.height_px, "of the projector or panel")
      ->required()
      ->check(CLI::Range(1, kMostScreenPx));
  verb.add_option("--cell-px", patterns.cell_px,
                  "side of the cells that are told apart, whose finest stripes are twice as wide; "
                  "a camera needs about 2 px of its own for each [1]")
      ->check(CLI::Range(1, kMostScreenPx));
}

ExitCode RunGrayCode(const std::filesystem::path& photos, const GrayCodePatterns& patterns,
                     double least_contrast, const std::filesystem::path& out, Progress& progress) {
  if (out.extension() != ".exr") {
    throw UsageError(out.string(), "is no .exr", "a map is written as EXR, of floats");
  }
  CheckWritable(out);
  const ScreenMap map = ReadGrayCode(photos, patterns, least_contrast, progress);
  SaveScreenMap(out, map);
  const SeenOfScreen seen = SeenOf(map);
  fmt::print(
      "{:.1f} % of {} x {} px decoded: they see columns {:g} to {:g} of {} px and rows {:g} to "
      "{:g} of {} px\n",
      100.0 * static_cast<double>(seen.num_valid) / static_cast<double>(map.valid.size()),
      map.width(), map.height(), seen.first_u, seen.last_u, patterns.width_px, seen.first_v,
      seen.last_v, patterns.height_px);
  fmt::print("{:.1f} % of the steps from cell to cell go back\n{}\n", 100 * ShareOfStepsBack(map),
             out.string());
  return ExitCode::kDone;
}

}  // namespace

void AddGrayCodePatterns(CLI::App& calibrate, Invocation& invocation) {
  struct Arguments {
    GrayCodePatterns patterns;
    std::filesystem::path out;
  };
  CLI::App& verb = *calibrate.add_subcommand(
      "gray-code-patterns", "stripes for a projector or panel to show, for `calibrate gray-code`");
  auto arguments = std::make_shared<Arguments>();
  AddScreen(verb, arguments->patterns);
  verb.add_option("--out", arguments->out, "folder to write to")->required();
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Writes gray_001_column_bit_10.png and so on, which sort in the order in which they are\n"
      "photographed. Show each pixel for pixel, unscaled, and move neither camera nor screen.\n\n"
      "Example\n"
      "  lamella calibrate gray-code-patterns --width-px 1280 --height-px 800 --out stripes");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      WriteGrayCode(arguments->out, arguments->patterns, progress);
      fmt::print("{} patterns\n{}\n", arguments->patterns.Count(), arguments->out.string());
      return ExitCode::kDone;
    };
  });
}

void AddGrayCode(CLI::App& calibrate, Invocation& invocation) {
  struct Arguments {
    GrayCodePatterns patterns;
    std::filesystem::path photos, out;
    double least_contrast = 0.05;
  };
  CLI::App& verb = *calibrate.add_subcommand(
      "gray-code",
      "which point of a projector or panel every pixel of a camera sees, from photographs of "
      "Gray-code stripes");
  auto arguments = std::make_shared<Arguments>();
  verb.add_option("PHOTOS", arguments->photos,
                  "folder of a photograph per pattern, which sort by name as the patterns do")
      ->required();
  AddScreen(verb, arguments->patterns);
  verb.add_option("--least-contrast", arguments->least_contrast,
                  "white less black of a pixel that is decoded, as a share of full scale, of the "
                  "files' numbers [0.05]")
      ->check(CLI::Range(0.001, 1.0));
  verb.add_option("--out", arguments->out, "map to write, an .exr")->required();
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "The order is that of OpenCV's GrayCodePattern, and of `calibrate gray-code-patterns`: the\n"
      "bits of the column from the most significant one on, each followed by its inverse; those\n"
      "of the row likewise; then white and black. Numbers in names count by their value: im2.png\n"
      "is before im10.png. One camera that does not move, of any response, all exposed alike.\n"
      "The map has float channels of the photographs' size: u, v, the middle of the cell that is\n"
      "seen (screen px, the first one's centre at 0.5; 0: not known), and sd_u, sd_v, their\n"
      "standard deviations. Few steps from cell to cell go back along a surface: more than some\n"
      "per cent say that a pattern lies in its inverse's place, or that the scene is in pieces.\n\n"
      "Examples\n"
      "  lamella calibrate gray-code captured --width-px 1280 --height-px 800 --out map.exr\n"
      "  lamella calibrate gray-code captured --width-px 1920 --height-px 1080 --cell-px 8 \\\n"
      "      --out map.exr");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      return RunGrayCode(arguments->photos, arguments->patterns, arguments->least_contrast,
                         arguments->out, progress);
    };
  });
}

}  // namespace lamella
