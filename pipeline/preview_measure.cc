#include "pipeline/preview_measure.h"

#include <algorithm>
#include <cmath>

#include "depth/resize_area.h"
#include "distribute/metrics.h"
#include "lightfield/color.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Of the pixel's size: the mean over two points so far on both sides of the middle is that of the
// whole pixel for cubic polynomials (Gauss-Legendre).
constexpr double kGaussPoint = 0.28867513459481287;

// The bundles whose mean a target is. Rays that are more than a view pixel apart stand for a square
// of their spacing (the capture's colours are filtered to it), others for a point of the view's
// picture.
std::vector<RayBundle> BundlesOfTarget(const Eye& eye, double mm_per_view_px) {
  if (eye.pixel_mm > 1.5 * mm_per_view_px) return {BundleOfEye(eye, 2)};
  std::vector<RayBundle> bundles(4, BundleOfEye(eye));
  for (std::size_t i = 0; i < bundles.size(); ++i) {
    bundles[i].origin += (i % 2 == 0 ? -kGaussPoint : kGaussPoint) * bundles[i].dx +
                         (i < 2 ? -kGaussPoint : kGaussPoint) * bundles[i].dy;
  }
  return bundles;
}

// Of the pupil's points each has one of its four bundles by turns: together they are spread over
// the pixel as well.
std::vector<RayBundle> BundlesOfTarget(const Eye& eye, const Pupil& pupil, double mm_per_view_px) {
  std::vector<RayBundle> bundles;
  for (const Eye& sample : PupilSamples(eye, pupil)) {
    const std::vector<RayBundle> of_sample = BundlesOfTarget(sample, mm_per_view_px);
    bundles.push_back(of_sample[bundles.size() % of_sample.size()]);
  }
  return bundles;
}

// Adds a bundle of a whole number of rays a pixel and axis.
void AddRays(ImageSpan<const RaySample> samples, float weight, Image<Rgb>& color,
             Image<float>& share) {
  const int split = samples.width / color.width();
  ParallelFor(0, color.height(), 16, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first) * split; y < static_cast<int>(last) * split; ++y) {
      const RaySample* row = samples.row(y);
      for (int x = 0; x < samples.width; ++x) {
        color(x / split, y / split) += weight * row[x].color;
        share(x / split, y / split) += weight * row[x].coverage;
      }
    }
  });
}

}  // namespace

PreviewPicture RenderTarget(const RaySource& placed, const Eye& eye,
                            const std::optional<Pupil>& pupil, double mm_per_view_px) {
  const std::vector<RayBundle> bundles =
      pupil ? BundlesOfTarget(eye, *pupil, mm_per_view_px) : BundlesOfTarget(eye, mm_per_view_px);
  const int width = bundles[0].width, height = bundles[0].height;
  const auto rays = static_cast<double>(bundles.size()) * width * height;
  const auto weight = static_cast<float>(static_cast<double>(eye.width) * eye.height / rays);
  Image<Rgb> color(eye.width, eye.height);
  PreviewPicture picture;
  picture.share = Image<float>(eye.width, eye.height);
  Image<RaySample> samples(width, height);
  for (const RayBundle& bundle : bundles) {
    placed.Query(bundle, {0, 0, width, height}, samples.span());
    AddRays(samples.span(), weight, color, picture.share);
  }
  picture.codes = EncodeSrgb8(color.span());
  return picture;
}

PreviewPicture RenderSimulated(const LayerImages& layers, const Display& display, const Eye& eye,
                               const std::optional<Pupil>& pupil) {
  EyePicture seen =
      pupil ? SimulateEye(layers, display, eye, *pupil) : SimulateEye(layers, display, eye);
  return {EncodeSrgb8(seen.color.span()), std::move(seen.coverage)};
}

PreviewPicture RenderSimulated(const CalibratedEyes& display, const Eye& eye,
                               const std::optional<Pupil>& pupil) {
  EyePicture seen = display.See(eye, pupil);
  return {EncodeSrgb8(seen.color.span()), std::move(seen.coverage)};
}

void LoseColor(PreviewPicture& picture) {
  Image<Rgb> light = DecodeSrgb8(picture.codes.span());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const float grey = Luminance(light.data()[i]);
    light.data()[i] = {grey, grey, grey};
  }
  picture.codes = EncodeSrgb8(light.span());
}

PreviewPicture CapturedPicture(ImageSpan<const Rgb> photograph, const CapturedEye& captured) {
  const Eye& eye = captured.eye;
  const Image<Rgb> part = ResizeArea(photograph.Sub(captured.pixels), eye.width, eye.height);
  return {EncodeSrgb8(part.span()), Image<float>(eye.width, eye.height, 1.0F)};
}

PreviewMetrics Compare(const PreviewPicture& a, const PreviewPicture& b, int border_px) {
  Image<float> both(a.share.width(), a.share.height());
  for (std::size_t i = 0; i < both.size(); ++i) {
    both.data()[i] = std::min(a.share.data()[i], b.share.data()[i]);
  }
  const MetricRegion all{border_px, {}}, seen{border_px, both.span()};
  const std::vector<std::optional<double>> ssim =
      SsimOfRegions(a.codes.span(), b.codes.span(), {all, seen});
  return {Psnr(a.codes.span(), b.codes.span(), all), Psnr(a.codes.span(), b.codes.span(), seen),
          ssim[0], ssim[1]};
}

double MeanShare(const PreviewPicture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.share.size(); ++i) {
    sum += static_cast<double>(picture.share.data()[i]);
  }
  return picture.share.empty() ? 0 : sum / static_cast<double>(picture.share.size());
}

}  // namespace lamella
