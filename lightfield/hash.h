// Hashes of content: SHA-256 to name a user's file for good, XXH3 (128 bits) to see that an input
// or an option changed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lamella {

std::string Sha256OfFile(const std::filesystem::path& path);  // lower-case hexadecimal
std::string ContentHash(std::string_view bytes);              // 32 hexadecimal digits
std::string ContentHashOfFile(const std::filesystem::path& path);

}  // namespace lamella
