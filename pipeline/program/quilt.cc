// lamella quilt: views to a quilt, a quilt to its views, and to a Looking Glass panel's image.
#include "pipeline/program/quilt.h"

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "lightfield/calibrated_sheet.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/calibration_record.h"
#include "pipeline/make_quilt.h"
#include "pipeline/visual_json.h"

namespace lamella {
namespace {

constexpr double kLeastAspect = 0.01, kMostAspect = 100;

void AddMake(CLI::App& quilt, Invocation& invocation) {
  struct Arguments {
    std::string views, out;
    MakeQuiltOptions options;
  };
  CLI::App& app = *quilt.add_subcommand(
      "make",
      "a folder of views, left to right by their names, to one PNG: view 0 is at the "
      "bottom left, then to the right, then upwards; tiles left over are black");
  auto arguments = std::make_shared<Arguments>();
  QuiltLayout& layout = arguments->options.layout;
  app.add_option("FOLDER", arguments->views, "pictures of one size")->required();
  app.add_option("--columns", layout.columns, "tiles in a row")
      ->required()
      ->check(CLI::Range(1, kMaxQuiltSide));
  app.add_option("--rows", layout.rows, "rows of tiles")
      ->required()
      ->check(CLI::Range(1, kMaxQuiltSide));
  app.add_option("--aspect", layout.aspect,
                 "width / height at which views are to be shown: the screen's (the views')")
      ->check(CLI::Range(kLeastAspect, kMostAspect));
  app.add_option("--out", arguments->out,
                 "a folder, or a .png; the name gets the layout, _qsCxRaA, where it has none")
      ->required();
  app.add_flag("--right-to-left", arguments->options.right_to_left,
               "the first name is the rightmost camera's");
  AddGlobalOptions(app, invocation);
  app.footer(
      "Examples:\n"
      "  lamella quilt make views --columns 8 --rows 6 --aspect 0.75 --out mine.png\n"
      "    writes mine_qs8x6a0.75.png");
  app.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      const MadeQuilt made =
          MakeQuilt(arguments->views, arguments->options, arguments->out, progress);
      const int black = made.layout.columns * made.layout.rows - made.views;
      fmt::print("{} views of {} x {} px in {} x {} tiles{}\n", made.views, made.tile_width,
                 made.tile_height, made.layout.columns, made.layout.rows,
                 black > 0 ? fmt::format(", {} of them black", black) : "");
      fmt::print("{}\n", made.file.string());
      return ExitCode::kDone;
    };
  });
}

// Of verbs that read a quilt.
void AddLayout(CLI::App& app, ReadQuiltOptions& options) {
  app.add_option("--columns", options.columns, "tiles in a row (as the name says)")
      ->check(CLI::Range(1, kMaxQuiltSide));
  app.add_option("--rows", options.rows, "rows of tiles (as the name says)")
      ->check(CLI::Range(1, kMaxQuiltSide));
  app.add_option("--views", options.views, "of them that are views (all but the last black ones)")
      ->check(CLI::Range(1, kMaxQuiltSide * kMaxQuiltSide));
}

void AddSplit(CLI::App& quilt, Invocation& invocation) {
  struct Arguments {
    std::string quilt, out;
    ReadQuiltOptions options;
  };
  CLI::App& app =
      *quilt.add_subcommand("split", "a quilt to its views: view_000.png is the leftmost camera's");
  auto arguments = std::make_shared<Arguments>();
  app.add_option("QUILT", arguments->quilt,
                 "a picture named NAME_qsCxRaA, e.g. mine_qs8x6a0.75.png")
      ->required();
  app.add_option("--out", arguments->out, "folder of the views")->required();
  AddLayout(app, arguments->options);
  AddGlobalOptions(app, invocation);
  app.footer(
      "Examples:\n"
      "  lamella quilt split mine_qs8x6a0.75.png --out views\n"
      "  lamella quilt split other.jpg --columns 5 --rows 9 --out views");
  app.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      const auto files = SplitQuilt(arguments->quilt, arguments->options, arguments->out, progress);
      fmt::print("{} views\n{}\n", files.size(), arguments->out);
      return ExitCode::kDone;
    };
  });
}

struct NativeArguments {
  std::string quilt, visual, out;
  NativeOptions options;
};

ExitCode RunNative(const NativeArguments& arguments) {
  if (std::filesystem::path(arguments.out).extension() != ".png") {
    throw UsageError(arguments.out, "is no .png", "loss would mix neighbouring directions");
  }
  const NativeImage native = MakeNative(arguments.quilt, arguments.visual, arguments.options);
  WriteCodes8(arguments.out, native.codes.span());
  fmt::print("{} views on {} x {} px for {}\n{}\n", native.views, native.codes.width(),
             native.codes.height(), native.serial, arguments.out);
  return ExitCode::kDone;
}

void AddNative(CLI::App& quilt, Invocation& invocation) {
  CLI::App& app = *quilt.add_subcommand(
      "native", "a quilt to the image that one Looking Glass panel shows without further scaling");
  auto arguments = std::make_shared<NativeArguments>();
  NativeOptions& options = arguments->options;
  app.add_option("QUILT", arguments->quilt, "a picture named NAME_qsCxRaA")->required();
  app.add_option("--visual", arguments->visual, "visual.json of that very device")->required();
  app.add_option("--out", arguments->out, "the image, a .png")->required();
  app.add_option("--filter", options.filter,
                 "between views: nearest, linear, gaussian or wide-gaussian [nearest]");
  app.add_option("--center", options.center, "phase in lenses, instead of the calibration's");
  app.add_flag("--reverse-views", options.reverse_views,
               "for a quilt whose view 0 is the rightmost camera's");
  app.add_option("--aspect", options.quilt.aspect, "width / height of the views (as the name says)")
      ->check(CLI::Range(kLeastAspect, kMostAspect));
  AddLayout(app, options.quilt);
  AddGlobalOptions(app, invocation);
  app.footer(
      "Examples:\n"
      "  lamella quilt native mine_qs8x6a0.75.png --visual visual.json --out panel.png");
  app.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress&) { return RunNative(*arguments); };
  });
}

struct VisualArguments {
  std::string calibration, out;
  double distance_mm = 600;
};

ExitCode RunVisual(const VisualArguments& arguments) {
  const Calibration calibration = LoadCalibration(arguments.calibration);
  if (calibration.layers.size() != 1) {
    throw InputError(arguments.calibration,
                     fmt::format("is of {} layers", calibration.layers.size()),
                     "visual.json is of displays with one lenticular sheet");
  }
  const SheetForViewer sheet =
      SheetFor(calibration.layers[0], arguments.distance_mm, arguments.calibration);
  VisualJson visual;
  visual.serial = calibration.display;
  visual.panel = sheet.panel;
  visual.view_cone_deg = sheet.view_cone_deg;
  WriteVisualJson(arguments.out, visual);
  fmt::print("pitch {:.6g} lenses per inch, slope {:.6g}, center {:.6g}\n{}\n",
             sheet.panel.pitch_per_in, sheet.panel.slope, sheet.panel.center, arguments.out);
  return ExitCode::kDone;
}

void AddVisual(CLI::App& quilt, Invocation& invocation) {
  CLI::App& app = *quilt.add_subcommand(
      "visual", "a lenticular display's calibration.json as a visual.json, for one distance");
  auto arguments = std::make_shared<VisualArguments>();
  app.add_option("CALIBRATION", arguments->calibration, "calibration.json")->required();
  app.add_option("--distance-mm", arguments->distance_mm, "of the viewer from the lenses [600]")
      ->check(CLI::PositiveNumber);
  app.add_option("--out", arguments->out, "visual.json to write")->required();
  AddGlobalOptions(app, invocation);
  app.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress&) { return RunVisual(*arguments); };
  });
}

}  // namespace

void AddQuilt(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "quilt", "quilts of views, and what a Looking Glass display shows of them");
  app.require_subcommand(1);
  AddRenderQuilt(app, invocation);
  AddMake(app, invocation);
  AddSplit(app, invocation);
  AddNative(app, invocation);
  AddVisual(app, invocation);
}

}  // namespace lamella
