#include "armtrue/text/utf8.h"

#include <gtest/gtest.h>

namespace armtrue::utf8_test {
namespace {

TEST(Utf8, CharactersOfAllLengthsAreText) {
  EXPECT_TRUE(is_utf8(""));
  EXPECT_TRUE(is_utf8("Achse 1"));
  EXPECT_TRUE(is_utf8("\u00f6 \u00b0 \u20ac \ud55c \U0001F916"));
}

TEST(Utf8, WhatTheStandardForbidsIsNone) {
  EXPECT_FALSE(is_utf8("\xF6"));              // Latin-1
  EXPECT_FALSE(is_utf8("\xC3"));              // cut off
  EXPECT_FALSE(is_utf8("\xC0\xAF"));          // overlong
  EXPECT_FALSE(is_utf8("\xE0\x80\xAF"));      // overlong
  EXPECT_FALSE(is_utf8("\xED\xA0\x80"));      // surrogate
  EXPECT_FALSE(is_utf8("\xF4\x90\x80\x80"));  // beyond U+10FFFF
  EXPECT_FALSE(is_utf8("\x80"));
}

TEST(Utf8, Latin1BecomesUtf8) {
  EXPECT_EQ(as_utf8("Gr\xF6\xDF"
                    "e \xB0"),
            "Gr\u00f6\u00dfe \u00b0");
  EXPECT_EQ(as_utf8("Gr\u00f6\u00dfe"), "Gr\u00f6\u00dfe");
}

}  // namespace
}  // namespace armtrue::utf8_test
