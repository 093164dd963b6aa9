#include "io/gzip.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

#include <array>
#include <memory>
#include <stdexcept>

#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

constexpr size_t kMostUnpackedBytes = 64'000'000;  // the largest of 460 public programs has 3 MB
constexpr size_t kUnpackedBlock = 1 << 16;

std::string error_of(archive* handle) {
  const char* const text = archive_error_string(handle);
  return text ? text : "";
}

}  // namespace

bool is_gzip(const std::string& bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string gunzip(const std::string& bytes, const std::string& file) {
  const std::unique_ptr<archive, decltype(&archive_read_free)> reader(archive_read_new(),
                                                                      archive_read_free);
  archive_read_support_format_raw(reader.get());
  archive_read_support_filter_gzip(reader.get());
  const auto fail = [&] {
    throw InputError(fmt::format("{}: is damaged, or was cut off ({}); copy it again", file,
                                 error_of(reader.get())));
  };
  archive_entry* entry = nullptr;
  if (archive_read_open_memory(reader.get(), bytes.data(), bytes.size()) != ARCHIVE_OK ||
      archive_read_next_header(reader.get(), &entry) != ARCHIVE_OK)
    fail();
  std::string text;
  std::array<char, kUnpackedBlock> block;
  for (;;) {
    const la_ssize_t size = archive_read_data(reader.get(), block.data(), block.size());
    if (size == 0) return text;
    if (size < 0) fail();
    text.append(block.data(), static_cast<size_t>(size));
    if (text.size() > kMostUnpackedBytes)
      throw InputError(fmt::format("{}: holds more than {} MB, unpacked; no program is so large",
                                   file, kMostUnpackedBytes / 1'000'000));
  }
}

std::string gzip(const std::string& text) {
  const std::unique_ptr<archive, decltype(&archive_write_free)> writer(archive_write_new(),
                                                                       archive_write_free);
  archive_write_set_format_raw(writer.get());
  archive_write_add_filter_gzip(writer.get());
  archive_write_set_filter_option(writer.get(), "gzip", "timestamp", nullptr);
  archive_write_set_bytes_in_last_block(writer.get(), 1);
  std::string bytes;
  const auto append = [](archive*, void* to, const void* from, size_t size) -> la_ssize_t {
    static_cast<std::string*>(to)->append(static_cast<const char*>(from), size);
    return static_cast<la_ssize_t>(size);
  };
  const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(),
                                                                            archive_entry_free);
  archive_entry_set_pathname(entry.get(), "text");
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_size(entry.get(), static_cast<la_int64_t>(text.size()));
  if (archive_write_open(writer.get(), &bytes, nullptr, append, nullptr) != ARCHIVE_OK ||
      archive_write_header(writer.get(), entry.get()) != ARCHIVE_OK ||
      archive_write_data(writer.get(), text.data(), text.size()) != std::ssize(text) ||
      archive_write_close(writer.get()) != ARCHIVE_OK)
    throw std::runtime_error("cannot pack a program: " + error_of(writer.get()));
  return bytes;
}

}  // namespace armtrue
