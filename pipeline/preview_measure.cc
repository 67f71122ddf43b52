#include "pipeline/preview_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

// Where an eye's light passes, and the rays from there.
struct PupilPoint {
  Eye eye;
  std::vector<RayBundle> bundles;
};

// Of the pupil's points each has one of its four bundles by turns: together they are spread over
// the pixel as well.
std::vector<PupilPoint> PointsOfTarget(const Eye& eye, const std::optional<Pupil>& pupil,
                                       double mm_per_view_px) {
  if (!pupil) return {{eye, BundlesOfTarget(eye, mm_per_view_px)}};
  std::vector<PupilPoint> points;
  for (const Eye& sample : PupilSamples(eye, *pupil)) {
    const std::vector<RayBundle> of_sample = BundlesOfTarget(sample, mm_per_view_px);
    points.push_back({sample, {of_sample[points.size() % of_sample.size()]}});
  }
  return points;
}

// What an eye sees without a display, with a guess where nothing is known.
struct SeenTarget {
  Image<Rgb> color;
  SeenScene scene;
};

// Adds a bundle of a whole number of rays a pixel and axis.
void AddRays(ImageSpan<const RaySample> samples, float weight, const Eye& eye, SeenTarget& target) {
  SeenScene& scene = target.scene;
  const int split = samples.width / eye.width;
  const auto plane_mm = static_cast<float>(eye.plane_mm);
  ParallelFor(0, eye.height, 16, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first) * split; y < static_cast<int>(last) * split; ++y) {
      const RaySample* row = samples.row(y);
      for (int x = 0; x < samples.width; ++x) {
        const int column = x / split, line = y / split;
        const float known = weight * row[x].coverage;
        target.color(column, line) += weight * row[x].color;
        if (known > 0) scene.light(column, line) += known * row[x].color;
        scene.coverage(column, line) += known;
        float& z = scene.z(column, line);
        if (row[x].coverage > 0) z = std::max(z, plane_mm + row[x].z);
      }
    }
  });
}

SeenTarget SeenFrom(const RaySource& placed, const PupilPoint& point) {
  const int width = point.bundles[0].width, height = point.bundles[0].height;
  const Eye& eye = point.eye;
  constexpr float kFarthest = -std::numeric_limits<float>::infinity();
  SeenTarget target{
      Image<Rgb>(eye.width, eye.height),
      {Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height, kFarthest),
       Image<float>(eye.width, eye.height)}};
  const auto rays = static_cast<double>(point.bundles.size()) * width * height;
  const auto weight = static_cast<float>(static_cast<double>(eye.width) * eye.height / rays);
  Image<RaySample> samples(width, height);
  for (const RayBundle& bundle : point.bundles) {
    placed.Query(bundle, {0, 0, width, height}, samples.span());
    AddRays(samples.span(), weight, eye, target);
  }
  return target;
}

// Sums of pictures, each times a weight.
void AddPicture(const Image<Rgb>& picture, float weight, Image<Rgb>& sum) {
  if (sum.empty()) sum = Image<Rgb>(picture.width(), picture.height());
  for (std::size_t i = 0; i < sum.size(); ++i) sum.data()[i] += weight * picture.data()[i];
}

Image<float> LeastOf(const Image<float>& a, const Image<float>& b) {
  Image<float> least(a.width(), a.height());
  for (std::size_t i = 0; i < least.size(); ++i) {
    least.data()[i] = std::min(a.data()[i], b.data()[i]);
  }
  return least;
}

Image<float> KnownToBoth(const PreviewPicture& a, const PreviewPicture& b) {
  return LeastOf(a.share, b.share);
}

Image<float> LuminanceOf(const Image<Rgb>& light) {
  Image<float> luminance(light.width(), light.height());
  for (std::size_t i = 0; i < light.size(); ++i) {
    luminance.data()[i] = Luminance(light.data()[i]);
  }
  return luminance;
}

PreviewMetrics CompareCodes(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                            const Image<float>& known, int border_px) {
  const MetricRegion all{border_px, {}}, seen{border_px, known.span()};
  const std::vector<std::optional<double>> ssim = SsimOfRegions(a, b, {all, seen});
  return {Psnr(a, b, all), Psnr(a, b, seen), ssim[0], ssim[1]};
}

}  // namespace

EyeTarget RenderTarget(const RaySource& placed, const Eye& eye, const std::optional<Pupil>& pupil,
                       double mm_per_view_px, const TargetParts& parts) {
  const std::vector<PupilPoint> points = PointsOfTarget(eye, pupil, mm_per_view_px);
  const float weight = 1.0F / static_cast<float>(points.size());
  EyeTarget target;
  target.picture.share = Image<float>(eye.width, eye.height);
  Image<Rgb> color, limited;
  for (const PupilPoint& point : points) {
    SeenTarget seen = SeenFrom(placed, point);
    AddPicture(seen.color, weight, color);
    for (std::size_t i = 0; i < seen.scene.coverage.size(); ++i) {
      target.picture.share.data()[i] += weight * seen.scene.coverage.data()[i];
    }
    if (parts.limit != nullptr) {
      AddPicture(BandLimited(seen.scene, *parts.limit, point.eye), weight, limited);
    }
    if (pupil) continue;
    if (parts.shadows != nullptr) target.rims = RimsOf(seen.scene, *parts.shadows, eye);
    if (parts.keeps_light) {
      target.light = {eye,
                      {},
                      LuminanceOf(limited.empty() ? color : limited),
                      std::move(seen.scene.z),
                      target.picture.share.Clone()};
    }
  }
  target.picture.codes = EncodeSrgb8(color.span());
  if (!limited.empty()) target.band_limited = EncodeSrgb8(limited.span());
  return target;
}

PreviewPicture PictureOf(const EyePicture& seen) {
  return {EncodeSrgb8(seen.color.span()), seen.coverage.Clone()};
}

void KeepRows(const EyePicture& rows, int first_row, PreviewPicture& picture) {
  const Image<Rgb8> codes = EncodeSrgb8(rows.color.span());
  std::copy_n(codes.data(), codes.size(), picture.codes.row(first_row));
  std::copy_n(rows.coverage.data(), rows.coverage.size(), picture.share.row(first_row));
}

void AddSeen(const EyePicture& rows, int first_row, SeenAgainstTarget& light) {
  if (light.seen.empty()) light.seen = Image<float>(light.known.width(), light.known.height());
  float *seen = light.seen.row(first_row), *known = light.known.row(first_row);
  for (std::size_t i = 0; i < rows.color.size(); ++i) {
    seen[i] = Luminance(rows.color.data()[i]);
    known[i] = std::min(known[i], rows.coverage.data()[i]);
  }
}

void LoseColor(Image<Rgb8>& codes) {
  Image<Rgb> light = DecodeSrgb8(codes.span());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const float grey = Luminance(light.data()[i]);
    light.data()[i] = {grey, grey, grey};
  }
  codes = EncodeSrgb8(light.span());
}

PreviewPicture CapturedPicture(ImageSpan<const Rgb> photograph, const CapturedEye& captured) {
  const Eye& eye = captured.eye;
  const Image<Rgb> part = ResizeArea(photograph.Sub(captured.pixels), eye.width, eye.height);
  return {EncodeSrgb8(part.span()), Image<float>(eye.width, eye.height, 1.0F)};
}

PreviewMetrics Compare(const PreviewPicture& a, const PreviewPicture& b, int border_px) {
  return CompareCodes(a.codes.span(), b.codes.span(), KnownToBoth(a, b), border_px);
}

BandLimitMetrics CompareToBandLimited(const PreviewPicture& simulated, const EyeTarget& target,
                                      int border_px) {
  const ImageSpan<const Rgb8> limited = target.band_limited.span();
  const ImageSpan<const Rgb8> unlimited = target.picture.codes.span();
  const MetricRegion all{border_px, {}}, seen{border_px, target.picture.share.span()};
  return {CompareCodes(simulated.codes.span(), limited, KnownToBoth(simulated, target.picture),
                       border_px),
          {Psnr(unlimited, limited, all), Psnr(unlimited, limited, seen), {}, {}}};
}

std::optional<HaloErrors> MeasureHalo(const PreviewPicture& simulated, const EyeTarget& target,
                                      int border_px) {
  if (target.rims.empty()) return std::nullopt;
  const Image<float> known = KnownToBoth(simulated, target.picture);
  return SumHaloErrors(simulated.codes.span(), target.band_limited.span(), target.rims,
                       {border_px, known.span()});
}

double MeanShare(const PreviewPicture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.share.size(); ++i) {
    sum += static_cast<double>(picture.share.data()[i]);
  }
  return picture.share.empty() ? 0 : sum / static_cast<double>(picture.share.size());
}

}  // namespace lamella
