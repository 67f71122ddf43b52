// Images of which some rows at a time are read or written: a display's emitters and panels may be
// larger than memory. Written files appear whole (lightfield/atomic_file.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "lightfield/image.h"
#include "lightfield/image_io.h"

namespace lamella {

// What WriteExr writes, from the top: the same bytes where all but the last are multiples of 32
// rows. Close makes the file appear.
class ExrRowsWriter {
 public:
  ExrRowsWriter(const std::filesystem::path& path, const std::vector<std::string>& channels,
                int width, int height, ExrType type,
                ExrCompression compression = ExrCompression::kZip);
  ~ExrRowsWriter();
  ExrRowsWriter(ExrRowsWriter&&) noexcept;
  void Write(const std::vector<Channel>& rows);  // in the order of the names
  void Close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// A PNG of 8-bit codes that is written from the top. Close makes it appear.
class PngRowsWriter {
 public:
  PngRowsWriter(const std::filesystem::path& path, int width, int height, int channels,
                PngCoding coding);
  ~PngRowsWriter();
  PngRowsWriter(PngRowsWriter&&) noexcept;
  void Write(const Image<Rgb8>& rows);          // of 3 channels
  void Write(const Image<std::uint8_t>& rows);  // of 1
  void Close();

 private:
  void WriteRows(int count, const void* codes);
  struct State;
  std::unique_ptr<State> state_;
};

// Rows of an EXR in any order; InputError where it can't be read.
class ExrRowsReader {
 public:
  explicit ExrRowsReader(const std::filesystem::path& path);
  ~ExrRowsReader();
  ExrRowsReader(ExrRowsReader&&) noexcept;
  int width() const;
  int height() const;
  std::vector<Channel> Read(int first_row, int end_row);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// 8-bit sRGB codes of a file's rows, grey repeated to three channels; InputError where it can't be
// read. A PNG is decoded from the top: quickly where rows rise.
class CodeRowsReader {
 public:
  explicit CodeRowsReader(const std::filesystem::path& path);
  ~CodeRowsReader();
  CodeRowsReader(CodeRowsReader&&) noexcept;
  int width() const;
  int height() const;
  Image<Rgb8> Read(int first_row, int end_row);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lamella
