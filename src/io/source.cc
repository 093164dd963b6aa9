#include "armtrue/io/source.h"

#include <openssl/evp.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "armtrue/io/inputs_stay.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/utf8.h"
#include "io/table_json.h"

namespace armtrue {
namespace {

constexpr size_t kChunk = 1 << 16;
constexpr size_t kLongestLine = 16 << 20;
constexpr size_t kLargestText = 256 << 20;  // read at once

}  // namespace

void check_text(std::string_view text, const std::string& file, int first_line) {
  if (text.find('\0') != std::string_view::npos)
    throw InputError(file + ":" + std::to_string(first_line) +
                     ": is no text in UTF-8 (a zero byte stands in it); save it as such");
  for (size_t at = text.find('\r'); at != std::string_view::npos; at = text.find('\r', at + 1))
    if (at + 1 == text.size() || text[at + 1] != '\n')
      throw InputError(
          file + ":" +
          std::to_string(first_line + std::count(text.begin(), text.begin() + at, '\n')) +
          ": holds a carriage return (CR) without a line feed, as old Macs end lines; save the "
          "file with the line ends of Unix (LF) or Windows (CRLF)");
}

namespace {

// What the first bytes of a file say, and what its owner can do.
struct ForeignFile {
  std::string_view begins;
  const char* what;
  const char* remedy;
};

constexpr const char* kSaveAsCsv = "open it in a spreadsheet and save the sheet as CSV (UTF-8)";
constexpr const char* kUnpack = "unpack it and give the file inside";
constexpr const char* kExport = "export the table as CSV (UTF-8)";
constexpr const char* kRecode = "save it as UTF-8";

using namespace std::string_view_literals;
constexpr ForeignFile kForeignFiles[] = {
    {"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"sv, "an Excel workbook (.xls)", kSaveAsCsv},
    {"%PDF-"sv, "a PDF", kExport},
    {"\x1F\x8B"sv, "packed by gzip (.gz)", kUnpack},
    {"BZh91AY&SY"sv, "packed by bzip2 (.bz2)", kUnpack},
    {"\xFD\x37zXZ\0"sv, "packed by xz", kUnpack},
    {"\x28\xB5\x2F\xFD"sv, "packed by zstd (.zst)", kUnpack},
    {"7z\xBC\xAF\x27\x1C"sv, "a 7z archive", kUnpack},
    {"Rar!\x1A\x07"sv, "a RAR archive", kUnpack},
    {"MATLAB 5.0 MAT-file"sv, "a MATLAB file (.mat)", kExport},
    {"\x89HDF\r\n"sv, "an HDF5 file (also .mat)", kExport},
    {"\x89PNG\r\n"sv, "a picture (PNG)", kExport},
    {"\xFF\xD8\xFF"sv, "a picture (JPEG)", kExport},
    {"SQLite format 3\0"sv, "an SQLite database", kExport},
    {"\xFF\xFE"sv, "text in UTF-16", kRecode},
    {"\xFE\xFF"sv, "text in UTF-16", kRecode},
};

// An archive of the kind ZIP is a workbook of Excel or LibreOffice if files of such a name are in it.
ForeignFile kind_of_zip(std::string_view bytes) {
  const auto holds = [&](std::string_view name) { return bytes.find(name) != bytes.npos; };
  if (holds("opendocument.spreadsheet")) return {{}, "a spreadsheet (.ods)", kSaveAsCsv};
  if (holds("xl/") || holds("[Content_Types].xml"))
    return {{}, "an Excel workbook (.xlsx)", kSaveAsCsv};
  return {{}, "a ZIP archive", kUnpack};
}

void refuse_foreign(std::string_view bytes, const std::string& name) {
  const auto refuse = [&](const ForeignFile& kind) {
    throw InputError(name + ": is " + kind.what + "; " + kind.remedy);
  };
  if (bytes.starts_with("PK\x03\x04"sv)) refuse(kind_of_zip(bytes));
  for (const ForeignFile& kind : kForeignFiles)
    if (bytes.starts_with(kind.begins)) refuse(kind);
}

}  // namespace

struct Source::Digest {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  Digest() { EVP_DigestInit_ex(context, EVP_sha256(), nullptr); }
  ~Digest() { EVP_MD_CTX_free(context); }
};

Source::Source(const std::string& path)
    : name_(path.empty() || path == "-" ? "<stdin>" : path), digest_(std::make_unique<Digest>()) {
  if (name_ == "<stdin>") {
    static bool taken = false;
    if (std::exchange(taken, true))
      throw InputError("<stdin>: two files cannot both come from standard input; name one of them");
    note_input("-");
    file_ = stdin;
  } else {
    struct stat status {};
    if (stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode))
      throw InputError(path + ": is a folder; name a file in it");
    note_input(path);
    file_ = std::fopen(path.c_str(), "rb");
    if (!file_)
      throw InputError(path + ": " + std::strerror(errno) + "; check the name of the file");
  }
  buffer_.resize(kChunk);
}

Source::Source(std::string name, std::string_view block, int lines_before)
    : name_(std::move(name)),
      file_(nullptr),
      buffer_(block.begin(), block.end()),
      end_(block.size()),
      at_end_(true),
      line_number_(lines_before) {}

Source::~Source() {
  if (file_ && file_ != stdin) std::fclose(file_);
}

bool Source::fill() {
  if (at_end_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ == buffer_.size()) {
    if (buffer_.size() >= kLongestLine)
      throw InputError(name_ + ":" + std::to_string(line_number_ + 1) +
                       ": the line does not end; is this a text file?");
    buffer_.resize(2 * buffer_.size());
  }
  const size_t count = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_);
  if (count == 0) {
    if (std::ferror(file_)) throw InputError(name_ + ": " + std::strerror(errno));
    at_end_ = true;
    return false;
  }
  EVP_DigestUpdate(digest_->context, buffer_.data() + end_, count);
  if (is_new_) refuse_foreign({buffer_.data() + end_, count}, name_);
  is_new_ = false;
  end_ += count;
  return true;
}

bool Source::next_line(std::string_view& line) {
  size_t searched = 0;
  while (true) {
    const std::string_view text(buffer_.data() + begin_, end_ - begin_);
    if (const size_t newline = text.find('\n', searched); newline != text.npos) {
      line = text.substr(0, newline);
      begin_ += line.size() + 1;
      break;
    }
    searched = text.size();
    if (fill()) continue;
    if (begin_ == end_) return false;
    line = {buffer_.data() + begin_, end_ - begin_};
    begin_ = end_;
    break;
  }
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  check_text(line, name_, line_number_ + 1);
  if (++line_number_ == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
  char bits = 0;  // of all characters: the compiler takes many at once
  for (const char c : line) bits |= c;
  const bool is_ascii = (bits & 0x80) == 0;
  if (!is_ascii && !is_utf8(line)) line = converted_ = as_utf8(line);
  return true;
}

std::string Source::next_block(size_t bytes) {
  while (end_ - begin_ < bytes && fill()) {
  }
  const auto whole_lines = [&] {
    const std::string_view left(buffer_.data() + begin_, end_ - begin_);
    return at_end_ ? left.size() : left.rfind('\n') + 1;  // 0 where there is none
  };
  size_t size = whole_lines();
  while (size == 0 && fill()) size = whole_lines();
  std::string block(buffer_.data() + begin_, size);
  begin_ += size;
  for (size_t at = block.find('\n'); at != block.npos; at = block.find('\n', at + 1))
    ++line_number_;
  if (!block.empty() && block.back() != '\n') ++line_number_;
  return block;
}

void Source::take_json_as_table() {
  if (!file_ || line_number_ > 0 || (begin_ == end_ && !fill())) return;
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::string_view seen(buffer_.data() + begin_, end_ - begin_);
  const size_t first = seen.find_first_not_of(kBlanks);
  if (first == seen.npos || seen[first] != '[') return;
  const size_t second = seen.find_first_not_of(kBlanks, first + 1);
  if (second == seen.npos || (seen[second] != '{' && seen[second] != ']')) return;
  const std::string table = table_from_json(as_utf8(read_all()), name_);
  buffer_.assign(table.begin(), table.end());
  begin_ = 0;
  end_ = table.size();
}

std::string Source::read_all() {
  std::string text;
  do {
    if (text.size() > kLargestText)
      throw InputError(name_ + ": is larger than 256 MB; check its name");
    text.append(buffer_.data() + begin_, end_ - begin_);
    begin_ = end_;
  } while (fill());
  return text;
}

std::string Source::sha256() {
  unsigned char bytes[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_DigestFinal_ex(digest_->context, bytes, &size);
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += kDigits[bytes[i] >> 4];
    text += kDigits[bytes[i] & 15];
  }
  return text;
}

}  // namespace armtrue
