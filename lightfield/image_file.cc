#include <fstream>

#include <OpenImageIO/imagebuf.h>

#include "lightfield/atomic_file.h"
#include "lightfield/image_file-inl.h"
#include "lightfield/image_whole.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// Larger than any picture that fits in memory here; what claims more is a lie.
constexpr double kMaxPixels = 1 << 29;

void CheckSize(const OIIO::ImageSpec& spec, const fs::path& path) {
  const OIIO::ROI picture = PictureWindow(spec);
  const double pixels = 1.0 * picture.width() * picture.height();
  if (!(pixels >= 1 && pixels <= kMaxPixels)) {
    throw UnreadableImage(path, "it claims an absurd size");
  }
}

// What WhyNotWhole must see. An EXR of a display's emitters may be larger than memory.
std::string BytesToJudge(const fs::path& path) {
  std::string start(8, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  return file && !EndIsLookedAt(start) ? start : ReadText(path);
}

}  // namespace

Error UnreadableImage(const fs::path& path, const std::string& reason) {
  return InputError(path.string(), "is no readable image (" + reason + ")", kReplaceImage);
}

bool HasFloats(const OIIO::ImageSpec& spec) {
  return spec.format == OIIO::TypeDesc::FLOAT || spec.format == OIIO::TypeDesc::HALF ||
         spec.format == OIIO::TypeDesc::DOUBLE;
}

OIIO::ROI PictureWindow(const OIIO::ImageSpec& spec) {
  const OIIO::ROI full = OIIO::get_roi_full(spec);
  return HasFloats(spec) && full.npixels() > 0 ? full : OIIO::get_roi(spec);
}

void WithoutThreadsOfOpenExr() {
  [[maybe_unused]] static const bool set = OIIO::attribute("exr_threads", -1);
}

std::unique_ptr<OIIO::ImageInput> OpenImage(const fs::path& path) {
  WithoutThreadsOfOpenExr();
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw UnreadableImage(path, "no such file");
  const std::string why = WhyNotWhole(BytesToJudge(path));
  if (!why.empty()) throw UnreadableImage(path, why);
  // By default OpenImageIO multiplies colours by an unassociated alpha.
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) {
    const std::string reason = OIIO::geterror();
    throw UnreadableImage(path, reason.empty() ? "unknown format" : reason);
  }
  CheckSize(input->spec(), path);
  return input;
}

OIIO::ImageSpec PngSpec(int width, int height, int channels, PngCoding coding) {
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("oiio:ColorSpace", "sRGB");
  constexpr int kAverage = 64;  // PNG_FILTER_AVG
  if (coding == PngCoding::kPhotograph) {
    spec.attribute("compression", "rle");
    spec.attribute("png:filter", kAverage);
  }
  spec.attribute("png:compressionLevel", coding == PngCoding::kSmall ? 6 : 1);  // zlib's
  return spec;
}

}  // namespace lamella
