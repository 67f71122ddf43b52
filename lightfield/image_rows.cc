#include "lightfield/image_rows.h"

#include <cstdint>
#include <stdexcept>
#include <utility>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_file-inl.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

OIIO::ImageSpec ExrSpec(const std::vector<std::string>& channels, int width, int height,
                        ExrType type, ExrCompression compression) {
  OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()),
                       type == ExrType::kHalf ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  spec.channelnames = channels;
  spec.alpha_channel = -1;
  spec.attribute("compression", compression == ExrCompression::kNone  ? "none"
                                : compression == ExrCompression::kPiz ? "piz"
                                                                      : "zip");
  spec.attribute("DateTime", "");  // else OpenImageIO writes the present time
  return spec;
}

}  // namespace

// A file that OpenImageIO writes from the top, some rows at a time.
class RowsFile {
 public:
  RowsFile(const fs::path& path, OIIO::ImageSpec spec) : file_(path), spec_(std::move(spec)) {}

  void Write(int count, OIIO::TypeDesc type, const void* pixels) {
    const std::string name = file_.temporary().string();
    try {
      if (!out_) {
        out_ = OIIO::ImageOutput::create(name);
        if (!out_) throw std::runtime_error(OIIO::geterror());
        if (!out_->open(name, spec_)) throw std::runtime_error(out_->geterror());
      }
      if (!out_->write_scanlines(next_row_, next_row_ + count, 0, type, pixels)) {
        throw std::runtime_error(out_->geterror());
      }
    } catch (const std::exception& error) {
      file_.Fail(error);
    }
    next_row_ += count;
  }

  void Close() {
    try {
      if (next_row_ != spec_.height) {
        throw std::runtime_error(std::to_string(next_row_) + " of " + std::to_string(spec_.height) +
                                 " rows were written");
      }
      if (!out_->close()) throw std::runtime_error(out_->geterror());
      file_.Commit();
    } catch (const std::exception& error) {
      file_.Fail(error);
    }
  }

 private:
  AtomicFile file_;
  OIIO::ImageSpec spec_;
  std::unique_ptr<OIIO::ImageOutput> out_;
  int next_row_ = 0;
};

struct ExrRowsWriter::State {
  RowsFile file;
};

ExrRowsWriter::ExrRowsWriter(const fs::path& path, const std::vector<std::string>& channels,
                             int width, int height, ExrType type, ExrCompression compression)
    : state_(new State{{path, ExrSpec(channels, width, height, type, compression)}}) {
  WithoutThreadsOfOpenExr();
}

ExrRowsWriter::~ExrRowsWriter() = default;
ExrRowsWriter::ExrRowsWriter(ExrRowsWriter&&) noexcept = default;

void ExrRowsWriter::Write(const std::vector<Channel>& rows) {
  const std::size_t count = rows.size();
  std::vector<float> packed(count * rows.at(0).pixels.size());
  for (std::size_t c = 0; c < count; ++c) {
    const float* from = rows[c].pixels.data();
    for (std::size_t i = 0; i < rows[c].pixels.size(); ++i) packed[i * count + c] = from[i];
  }
  state_->file.Write(rows[0].pixels.height(), OIIO::TypeDesc::FLOAT, packed.data());
}

void ExrRowsWriter::Close() { state_->file.Close(); }

struct PngRowsWriter::State {
  RowsFile file;
};

PngRowsWriter::PngRowsWriter(const fs::path& path, int width, int height, int channels,
                             PngCoding coding)
    : state_(new State{{path, PngSpec(width, height, channels, coding)}}) {}

PngRowsWriter::~PngRowsWriter() = default;
PngRowsWriter::PngRowsWriter(PngRowsWriter&&) noexcept = default;

void PngRowsWriter::WriteRows(int count, const void* codes) {
  state_->file.Write(count, OIIO::TypeDesc::UINT8, codes);
}
void PngRowsWriter::Write(const Image<Rgb8>& rows) { WriteRows(rows.height(), rows.data()); }
void PngRowsWriter::Write(const Image<std::uint8_t>& rows) {
  WriteRows(rows.height(), rows.data());
}
void PngRowsWriter::Close() { state_->file.Close(); }

struct ExrRowsReader::State {
  fs::path path;
  std::unique_ptr<OIIO::ImageInput> in;
};

ExrRowsReader::ExrRowsReader(const fs::path& path) : state_(new State{path, OpenImage(path)}) {}
ExrRowsReader::~ExrRowsReader() = default;
ExrRowsReader::ExrRowsReader(ExrRowsReader&&) noexcept = default;

int ExrRowsReader::width() const { return state_->in->spec().width; }
int ExrRowsReader::height() const { return state_->in->spec().height; }

std::vector<Channel> ExrRowsReader::Read(int first_row, int end_row) {
  const OIIO::ImageSpec& spec = state_->in->spec();
  const std::size_t count = static_cast<std::size_t>(spec.nchannels);
  const int rows = end_row - first_row;
  std::vector<float> packed(count * static_cast<std::size_t>(spec.width) *
                            static_cast<std::size_t>(rows));
  if (!state_->in->read_scanlines(0, 0, spec.y + first_row, spec.y + end_row, 0, 0, spec.nchannels,
                                  OIIO::TypeDesc::FLOAT, packed.data())) {
    throw InputError(state_->path.string(), "is damaged (" + state_->in->geterror() + ")",
                     "run the stage that writes it again");
  }
  std::vector<Channel> channels;
  for (std::size_t c = 0; c < count; ++c) {
    Channel channel{spec.channelnames[c], Image<float>(spec.width, rows)};
    float* to = channel.pixels.data();
    for (std::size_t i = 0; i < channel.pixels.size(); ++i) to[i] = packed[i * count + c];
    channels.push_back(std::move(channel));
  }
  return channels;
}

struct CodeRowsReader::State {
  fs::path path;
  std::unique_ptr<OIIO::ImageInput> in;
};

CodeRowsReader::CodeRowsReader(const fs::path& path) : state_(new State{path, OpenImage(path)}) {}
CodeRowsReader::~CodeRowsReader() = default;
CodeRowsReader::CodeRowsReader(CodeRowsReader&&) noexcept = default;

int CodeRowsReader::width() const { return state_->in->spec().width; }
int CodeRowsReader::height() const { return state_->in->spec().height; }

Image<Rgb8> CodeRowsReader::Read(int first_row, int end_row) {
  Image<Rgb8> codes(width(), end_row - first_row);
  const int channels = state_->in->spec().nchannels < 3 ? 1 : 3;
  if (!state_->in->read_scanlines(0, 0, first_row, end_row, 0, 0, channels, OIIO::TypeDesc::UINT8,
                                  codes.data(), sizeof(Rgb8))) {
    throw UnreadableImage(state_->path, state_->in->geterror());
  }
  for (std::size_t i = 0; channels == 1 && i < codes.size(); ++i) {
    codes.data()[i].g = codes.data()[i].b = codes.data()[i].r;
  }
  return codes;
}

}  // namespace lamella
