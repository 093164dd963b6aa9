#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "programs/krl_syntax.h"
#include "programs/text_edit.h"

namespace armtrue {

/// Collects for each frame of a program the texts that the moves want it to have.
class KrlFrameTexts {
 public:
  /// Both must outlive it.
  KrlFrameTexts(const KrlProgram& program, const KrlSyntax& syntax)
      : program_(program), syntax_(syntax), uses_(syntax.frames.size()) {}

  /// The frame of a target that refers to one, itself or by name.
  const KrlFrame& frame(const KrlTarget& target) const {
    return syntax_.frames[static_cast<size_t>(target.frame)];
  }
  /// The text of the target with other values (NaN: as it is). `pose`: before, the pose that it
  /// inherits from; after, the pose that it gives.
  std::string text(const KrlTarget& target, const KrlValues& values, KrlValues& pose) const;
  /// Says that the target is to have this text.
  void write(const KrlTarget& target, const KrlValues& values, KrlValues& pose) {
    uses_[static_cast<size_t>(target.frame)].push_back({&target, text(target, values, pose)});
  }

  /// Changes a frame where it stands, if all moves that use it want the same text and nothing else
  /// uses its name. Otherwise replaces the name in each move that wants another text by a frame.
  std::vector<TextEdit> edits() const;

 private:
  struct Use {
    const KrlTarget* target;
    std::string text;
  };
  std::string_view text_of(const KrlFrame& frame) const {
    return frame.in_dat ? program_.dat->text : program_.src.text;
  }

  const KrlProgram& program_;
  const KrlSyntax& syntax_;
  std::vector<std::vector<Use>> uses_;  // by frame
};

}  // namespace armtrue
