// lamella quilt render: a capture's quilt, and its image for one Looking Glass panel.
#include "pipeline/render_quilt.h"

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/pipeline.h"
#include "pipeline/program/quilt.h"

namespace lamella {
namespace {

struct RenderArguments {
  std::string workspace, out, quality;
  RenderQuiltOptions options;
  OptionFlags flags;
};

std::vector<OptionTable> TablesOf(RenderQuiltOptions& options) {
  return {{"placement", Describe(options.placement)}, Describe(options.render)};
}

ExitCode RunRender(RenderArguments& arguments, Progress& progress) {
  const Workspace workspace(arguments.workspace);
  RenderQuiltOptions& options = arguments.options;
  options.render = OptionsOf(workspace).render;
  if (!arguments.quality.empty()) ApplyQuality(ParseQuality(arguments.quality), options.render);
  arguments.flags.Apply(TablesOf(options));
  const RenderedQuilt quilt = RenderQuilt(workspace, options, arguments.out, progress);
  for (const auto& [what, value] : quilt.summary) fmt::print("{:<18} {}\n", what, value);
  fmt::print("{}\n", quilt.file.string());
  if (!quilt.native.empty()) fmt::print("{}\n", quilt.native.string());
  return ExitCode::kDone;
}

void AddQuiltOptions(CLI::App& verb, RenderQuiltOptions& options) {
  CLI::Option* visual = verb.add_option(
      "--visual", options.visual,
      "visual.json of the device: its screen, cone and published quilt are used, and the image "
      "that it shows is written, too");
  verb.add_option("--columns", options.columns,
                  "tiles in a row (the device's; else 8, of a lying screen 5)")
      ->check(CLI::Range(1, kMaxQuiltSide));
  verb.add_option("--rows", options.rows,
                  "rows of tiles (the device's; else 6, of a lying screen 9)")
      ->check(CLI::Range(1, kMaxQuiltSide));
  verb.add_option("--views", options.views, "of the tiles; the others are black (all)")
      ->check(CLI::Range(1, kMaxQuiltSide * kMaxQuiltSide));
  verb.add_option("--width", options.width_px,
                  "of the quilt, px (the device's; else 3360, of a lying screen 4096; with other "
                  "tiles or an aspect: square pixels, as many)")
      ->check(CLI::Range(1, kMaxQuiltPx));
  verb.add_option("--height", options.height_px, "of the quilt, px, likewise")
      ->check(CLI::Range(1, kMaxQuiltPx));
  verb.add_option("--cone", options.cone_deg,
                  "degrees from the first view's direction to the last one's (the device's; "
                  "Portrait: 40)")
      ->check(CLI::Range(kLeastConeDeg, kMostConeDeg));
  verb.add_option("--aspect", options.aspect, "width / height of the screen (Portrait: 0.75)")
      ->check(CLI::Range(0.01, 100.0))
      ->excludes(visual);
  verb.add_option("--screen-height-mm", options.screen_height_mm, "of the screen (Portrait: 160.6)")
      ->check(CLI::Range(1e-3, 1e6))
      ->excludes(visual);
  verb.add_flag("--guess-unseen", options.guess_unseen,
                "rays that no photograph saw, black otherwise, get a colour from around them");
  verb.add_option("--filter", options.filter,
                  "of the device's image between views: nearest, linear, gaussian or "
                  "wide-gaussian [nearest]");
}

}  // namespace

void AddRenderQuilt(CLI::App& quilt, Invocation& invocation) {
  CLI::App& verb = *quilt.add_subcommand(
      "render",
      "a capture to a quilt: its views rendered from a workspace whose stage depth is done, "
      "rays that no photograph saw black; and to the image of one Looking Glass panel");
  auto arguments = std::make_shared<RenderArguments>();
  verb.add_option("--workspace,-w", arguments->workspace, "folder of the capture's results")
      ->required();
  verb.add_option("--out", arguments->out,
                  "a folder, or a .png; the name gets the layout, _qsCxRaA, where it has none")
      ->required();
  AddQuiltOptions(verb, arguments->options);
  verb.add_option(
      "--quality", arguments->quality,
      "set of options: draft, balanced or best (the workspace's); finer options go on top");
  arguments->flags.Add(verb, TablesOf(arguments->options));
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Examples:\n"
      "  lamella run photographs -w W --until depth\n"
      "  lamella quilt render -w W --out castle.png      writes castle_qs8x6a0.75.png\n"
      "  lamella quilt render -w W --visual visual.json --out castle.png\n"
      "    and castle_native.png, for that device alone");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) { return RunRender(*arguments, progress); };
  });
}

}  // namespace lamella
