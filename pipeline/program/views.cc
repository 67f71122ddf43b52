// lamella views: chosen cameras rendered from the capture. And how images are compared.
#include "pipeline/program/views.h"

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/pipeline.h"
#include "pipeline/program/command_line.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

std::string Figure(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

// Means over the views that have the figure.
class Mean {
 public:
  void Add(const std::optional<double>& value) {
    if (!value) return;
    sum_ += *value;
    ++count_;
  }
  std::optional<double> Value() const {
    return count_ > 0 ? std::optional<double>(sum_ / count_) : std::nullopt;
  }

 private:
  double sum_ = 0;
  int count_ = 0;
};

void PrintView(const std::string& name, double seen, const std::optional<double>& psnr,
               const std::optional<double>& psnr_seen, const std::optional<double>& gain) {
  fmt::print("{:<24} {:>8.2f} {:>8} {:>9} {:>10}\n", name, 100 * seen, Figure(psnr, 2),
             Figure(psnr_seen, 2), Figure(gain, 2));
}

void PrintImage(const ImageComparison& image) {
  fmt::print("{:<24} {:>8} {:>8} {:>8.2f} {:>9} {:>9}\n", image.name, Figure(image.psnr, 2),
             Figure(image.ssim, 4), 100 * image.seen, Figure(image.psnr_seen, 2),
             Figure(image.ssim_seen, 4));
}

}  // namespace

ExitCode RunViews(const ViewsArguments& arguments, Progress& progress) {
  const std::vector<RenderedView> views = RenderViews(arguments, progress);
  Mean seen, psnr, psnr_seen, gain;
  fmt::print("{:<24} {:>8} {:>8} {:>9} {:>10}\n", "view", "seen %", "psnr dB", "seen dB",
             "with gain");
  for (const RenderedView& view : views) {
    PrintView(view.name, view.seen, view.psnr, view.psnr_seen, view.psnr_seen_gain);
    seen.Add(view.seen);
    psnr.Add(view.psnr);
    psnr_seen.Add(view.psnr_seen);
    gain.Add(view.psnr_seen_gain);
  }
  PrintView("mean", seen.Value().value_or(0), psnr.Value(), psnr_seen.Value(), gain.Value());
  return ExitCode::kDone;
}

ExitCode RunCompareImages(const std::filesystem::path& a, const std::filesystem::path& b,
                          const CompareImagesOptions& options) {
  const ImageComparisons result = CompareImages(a, b, options);
  fmt::print("{:<24} {:>8} {:>8} {:>8} {:>9} {:>9}\n", "image", "psnr dB", "ssim", "seen %",
             "seen dB", "seen ssim");
  for (const ImageComparison& image : result.images) PrintImage(image);
  PrintImage(result.mean);
  for (const std::string& name : result.only_a) fmt::print("only in {}: {}\n", a.string(), name);
  for (const std::string& name : result.only_b) fmt::print("only in {}: {}\n", b.string(), name);
  return ExitCode::kDone;
}

void AddViews(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand("views",
                                          "render chosen cameras from a workspace's views and "
                                          "depth: NAME.png, whose alpha is the share "
                                          "of each pixel that a view saw");
  auto arguments = std::make_shared<ViewsArguments>();
  auto quality = std::make_shared<std::string>();
  auto flags = std::make_shared<OptionFlags>();
  app.add_option("--workspace,-w", arguments->workspace, "folder of the results")->required();
  app.add_option(
         "--cameras", arguments->cameras,
         "transforms.json, or a folder of .camera files, of an HCI grid or of a COLMAP model. "
         "Known cameras given to `capture` share the workspace's world; where COLMAP found "
         "the poses, cameras must be in that frame (W/poses/transforms.json)")
      ->required();
  app.add_option("--out", arguments->out, "folder of the pictures")->required();
  app.add_option("--views", arguments->views, "which cameras: NAME|GLOB|!NAME,... (all)");
  app.add_option("--images", arguments->images,
                 "photographs of the same names to compare with (those of --cameras)");
  app.add_option("--size", arguments->size_px,
                 "longer side, px, of what is rendered and compared (the camera's)")
      ->check(CLI::Range(1, 1 << 16));
  app.add_option("--border", arguments->border_px, "px left out on every side when comparing [0]")
      ->check(CLI::Range(0, 1 << 16));
  app.add_option(
      "--quality", *quality,
      "set of options: draft, balanced or best (the workspace's); finer options go on top");
  flags->Add(app, {Describe(arguments->render)});
  AddGlobalOptions(app, invocation);
  app.callback([arguments, quality, flags, &invocation] {
    invocation.action = [arguments, quality, flags](Progress& progress) {
      arguments->render = OptionsOf(Workspace(arguments->workspace)).render;
      if (!quality->empty()) ApplyQuality(ParseQuality(*quality), arguments->render);
      flags->Apply({Describe(arguments->render)});
      return RunViews(*arguments, progress);
    };
  });
}

void AddCompareImages(CLI::App& compare, Invocation& invocation) {
  struct Arguments {
    std::filesystem::path a, b;
    CompareImagesOptions options;
  };
  CLI::App& app = *compare.add_subcommand(
      "images",
      "pictures on 8-bit sRGB codes: PSNR, SSIM; over all pixels and over those whose alpha "
      "is 0.5 or more");
  auto arguments = std::make_shared<Arguments>();
  app.add_option("A", arguments->a, "a picture, or a folder of them")->required();
  app.add_option("B", arguments->b, "a picture, or a folder with pictures of the same names")
      ->required();
  app.add_option("--border", arguments->options.border_px, "px left out on every side [0]")
      ->check(CLI::Range(0, 1 << 16));
  app.add_option("--size", arguments->options.size_px,
                 "longer side, px, that both are resized to first (area filter)")
      ->check(CLI::Range(1, 1 << 16));
  AddGlobalOptions(app, invocation);
  app.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress&) {
      return RunCompareImages(arguments->a, arguments->b, arguments->options);
    };
  });
}

}  // namespace lamella
