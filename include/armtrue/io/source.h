#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace armtrue {

/// A file, or standard input for "-" or "", read line by line in chunks, with the SHA-256 of its
/// bytes. Errors throw InputError, also for a file that its first bytes show to be no text, such as
/// a workbook of Excel.
class Source {
 public:
  explicit Source(const std::string& path);
  /// The lines of a block from next_block() of the source `name`, after `lines_before` earlier
  /// lines.
  Source(std::string name, std::string_view block, int lines_before);
  ~Source();
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  /// For messages: the path, or "<stdin>".
  const std::string& name() const { return name_; }

  /// The next line without its end (LF or CRLF), in UTF-8, see as_utf8(); false at the end of the
  /// file. Valid until the next call.
  bool next_line(std::string_view& line);
  int line_number() const { return line_number_; }

  /// The next whole lines, at least `bytes` long unless the file ends before; empty at its end.
  std::string next_block(size_t bytes);

  /// If the file is a list of JSON, goes on as if it were the CSV table of these rows; see
  /// armtrue-formats(5). Call it before anything is read.
  void take_json_as_table();

  /// The rest of the file.
  std::string read_all();

  /// SHA-256 in hexadecimal, after everything is read.
  std::string sha256();

 private:
  bool fill();

  std::string name_;
  std::FILE* file_;
  struct Digest;
  std::unique_ptr<Digest> digest_;
  std::vector<char> buffer_;
  std::string converted_;  // the last line that was not in UTF-8
  size_t begin_ = 0, end_ = 0;
  bool is_new_ = true;  // nothing was read
  bool at_end_ = false;
  int line_number_ = 0;
};

/// Throws InputError for a zero byte, which does not occur in UTF-8 text, and for a carriage return
/// outside CRLF. With line ends of old Macs the whole file would be one line.
void check_text(std::string_view text, const std::string& file, int first_line = 1);

}  // namespace armtrue
