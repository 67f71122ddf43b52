#include "lightfield/hash.h"

#include <array>
#include <fstream>
#include <functional>
#include <memory>
#include <vector>

#include <openssl/evp.h>
#include <xxhash.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

std::string Hexadecimal(const unsigned char* bytes, std::size_t count) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    text += kDigits[bytes[i] >> 4];
    text += kDigits[bytes[i] & 15];
  }
  return text;
}

void ForEachBlock(const std::filesystem::path& path,
                  const std::function<void(const char*, std::size_t)>& take) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw InputError(path.string(), "can't be read", "check that it exists and is readable");
  }
  std::vector<char> block(1 << 20);
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    take(block.data(), static_cast<std::size_t>(file.gcount()));
  }
}

std::string Digits(XXH128_hash_t hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  return Hexadecimal(canonical.digest, sizeof canonical.digest);
}

}  // namespace

std::string Sha256OfFile(const std::filesystem::path& path) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        &EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  ForEachBlock(path, [&](const char* data, std::size_t size) {
    EVP_DigestUpdate(context.get(), data, size);
  });
  std::array<unsigned char, 32> digest{};
  EVP_DigestFinal_ex(context.get(), digest.data(), nullptr);
  return Hexadecimal(digest.data(), digest.size());
}

std::string ContentHash(std::string_view bytes) {
  return Digits(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string ContentHashOfFile(const std::filesystem::path& path) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  ForEachBlock(path, [&](const char* data, std::size_t size) {
    XXH3_128bits_update(state.get(), data, size);
  });
  return Digits(XXH3_128bits_digest(state.get()));
}

}  // namespace lamella
