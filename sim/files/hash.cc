#include "sim/files/hash.h"

#include <fmt/format.h>
#include <sha2.h>
#include <xxhash.h>

namespace sim::files {
namespace {

XXH3_state_t* xxh(void* state) { return static_cast<XXH3_state_t*>(state); }

}  // namespace

Hash::Hash() : state_(XXH3_createState(), [](void* state) { XXH3_freeState(xxh(state)); }) {
  XXH3_128bits_reset(xxh(state_.get()));
}

void Hash::add(std::string_view bytes) {
  XXH3_128bits_update(xxh(state_.get()), bytes.data(), bytes.size());
  bytes_ += bytes.size();
}

void Hash::add_part(std::string_view bytes) {
  add(fmt::format("{}:", bytes.size()));
  add(bytes);
}

std::string Hash::hex() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(xxh(state_.get()));
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

HashedFile::HashedFile(const fs::path& file) : file_(file), out_(file, std::ios::binary) {
  if (!out_) fail_by_errno(file_, "cannot be created");
}

void HashedFile::write(std::string_view bytes) {
  out_.write(bytes.data(), std::streamsize(bytes.size()));
  if (!out_) fail_by_errno(file_, "cannot be written");
  hash_.add(bytes);
}

void HashedFile::close() {
  out_.close();
  if (!out_) fail_by_errno(file_, "cannot be written");
}

std::string sha256(std::string_view bytes) {
  SHA2_CTX context;
  SHA256Init(&context);
  SHA256Update(&context, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::string digest(SHA256_DIGEST_LENGTH, '\0');
  SHA256Final(reinterpret_cast<std::uint8_t*>(digest.data()), &context);
  return digest;
}

}  // namespace sim::files
