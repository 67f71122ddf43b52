// Image files as OpenImageIO opens and writes them: what reading and writing whole pictures
// (image_io.h) and rows of them (image_rows.h) have in common. Heavy: for .cc files only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <OpenImageIO/imageio.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"

namespace lamella {

inline constexpr const char* kReplaceImage =
    "replace the file or leave it out with --views '!NAME'";

// The InputError of a file that is no image, or not a whole one.
Error UnreadableImage(const std::filesystem::path& path, const std::string& reason);

// Opens the file and looks at its header; colours come as the file has them, not multiplied by its
// alpha. UnreadableImage where it is absent, no image, an absurdly large one or cut off: what is
// wrong with its end is found before a decoder sees it, since those write to standard error of
// their own.
std::unique_ptr<OIIO::ImageInput> OpenImage(const std::filesystem::path& path);

// Linear by convention.
bool HasFloats(const OIIO::ImageSpec& spec);

// The picture is the display window: a renderer's data window may be smaller or larger.
OIIO::ROI PictureWindow(const OIIO::ImageSpec& spec);

// Rows of an EXR are coded by the thread that asks. With threads of OpenEXR's own every open file
// would hold two blocks of rows for each, and a display's emitters are many files at once.
void WithoutThreadsOfOpenExr();

// 8 bits a channel; alpha is unassociated.
OIIO::ImageSpec PngSpec(int width, int height, int channels, PngCoding coding);

}  // namespace lamella
