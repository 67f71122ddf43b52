// lamella displays: list the presets, show one as TOML, check a user's file.
#include "distribute/displays.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "lightfield/display.h"
#include "lightfield/error.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

std::string Positions(const Display& display) {
  constexpr std::size_t kMostNamed = 8;
  if (display.layers.size() > kMostNamed) {
    return fmt::format("{} {} from {:g} to {:g} mm", display.layers.size(),
                       display.varifocal ? "planes" : "layers", display.layers.front().position_mm,
                       display.layers.back().position_mm);
  }
  std::string layers;
  for (const Layer& layer : display.layers) {
    layers += fmt::format("{}{:g}", layers.empty() ? "" : ", ", layer.position_mm);
  }
  return fmt::format("{} layer{} at {} mm", display.layers.size(),
                     display.layers.size() == 1 ? "" : "s", layers);
}

std::string Describe(const Barrier& barrier) {
  return fmt::format("barrier of {0}x{0} px every {1} px in {2} slots", barrier.aperture_px,
                     barrier.period_px, barrier.slots * barrier.slots);
}

std::string Describe(const LensletArray& lenses) {
  const bool square = lenses.lattice == LensletArray::Lattice::kSquare;
  return fmt::format("{} lenslets of {:g} px", square ? "square" : "hexagonal", lenses.pitch_px);
}

std::string Describe(const Lenticular& lenses) {
  return fmt::format("lenticular lenses of {:g} sub-pixels, slant {:.4g}",
                     lenses.subpixels_per_lens, lenses.slant);
}

std::string Describe(const BarePanel& bare) {
  return fmt::format("bare panels for eyes in {0:g} x {0:g} mm", bare.eye_box_mm);
}

// The optics of the first layer, and over all of them the field of view, which a relay changes.
std::string DescribeOptics(const Display& display) {
  const Layer& layer = display.layers.front();
  std::string text = std::visit([](const auto& optics) { return Describe(optics); }, layer.optics);
  if (std::holds_alternative<BarePanel>(layer.optics)) return text;
  const int views = DirectionsPerAxis(layer);
  text += std::holds_alternative<Lenticular>(layer.optics) ? fmt::format(", {} views", views)
                                                           : fmt::format(", {0}x{0} views", views);
  double least = FieldOfViewDeg(display, layer), most = least;
  for (const Layer& other : display.layers) {
    least = std::min(least, FieldOfViewDeg(display, other));
    most = std::max(most, FieldOfViewDeg(display, other));
  }
  text += most - least < 0.05 ? fmt::format(" over {:.1f} degrees", most)
                              : fmt::format(" over {:.1f} to {:.1f} degrees", least, most);
  const double guard = GuardShare(layer);
  return guard > 0 ? text + fmt::format(", {:.1f} % guard pixels", 100 * guard) : text;
}

std::string Describe(const Display& display) {
  return fmt::format("{} x {} px of {:.4f} mm, {}, {}", display.width_px, display.height_px,
                     display.pitch_mm, Positions(display), DescribeOptics(display));
}

ExitCode List() {
  for (const std::string& name : DisplayNames()) {
    fmt::print("{:<24} {}\n", name, Describe(FindDisplay(name)));
  }
  return ExitCode::kDone;
}

// A line for every file, and the code of the first that is not right.
ExitCode Check(const std::vector<std::string>& files) {
  ExitCode code = ExitCode::kDone;
  for (const std::string& file : files) {
    try {
      fmt::print("{}: good: {}\n", file, Describe(FindDisplay(file)));
    } catch (const Error& error) {
      fmt::print(stderr, "lamella: {}\n", error.what());
      if (code == ExitCode::kDone) code = error.code();
    }
  }
  return code;
}

}  // namespace

void AddDisplays(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "displays", "the displays that the program knows, and checks of your own");
  app.require_subcommand(0, 1);
  // Alone it lists; a subcommand's callback comes later and takes its place.
  app.parse_complete_callback(
      [&invocation] { invocation.action = [](Progress&) { return List(); }; });
  app.add_subcommand("list", "names and sizes of the presets (also without a subcommand)");
  auto name = std::make_shared<std::string>();
  CLI::App& show =
      *app.add_subcommand("show", "a display as TOML: the start of a file of your own");
  show.add_option("DISPLAY", *name, "preset or file")->required();
  show.callback([name, &invocation] {
    invocation.action = [name](Progress&) {
      fmt::print("{}", ToToml(FindDisplay(*name)));
      return ExitCode::kDone;
    };
  });
  CLI::App& check =
      *app.add_subcommand("check", "are display files right? one line for each tells");
  auto files = std::make_shared<std::vector<std::string>>();
  check.add_option("FILE", *files, "display files (TOML)")->required();
  check.callback(
      [files, &invocation] { invocation.action = [files](Progress&) { return Check(*files); }; });
}

}  // namespace lamella
