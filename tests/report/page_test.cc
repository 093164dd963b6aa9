// A page shows the values of a product where they stand in it.

#include "report/page.h"

#include <gmock/gmock.h>

namespace armtrue {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const Document& product() {
  static const Document document("", "",
                                 {{"all/ap_mm", "0.1234"},
                                  {"all/rp_mm", "3.1e-06"},
                                  {"all/ap_mrad", "-4.9e-05"},
                                  {"all/none_mm", "0"},
                                  {"p", "3.1e-06"},
                                  {"notes/0", "a < b"},
                                  {"notes/1", "c"},
                                  {"poses/0/pose", "1"},
                                  {"poses/0/std_mm", "2"},
                                  {"poses/1/pose", "x"}});
  return document;
}

Page page() {
  static const PageHead head{product(), {}, {}};
  return {head, "arm", "test"};
}

TEST(Page, ShowsAValueWithItsPath) {
  EXPECT_EQ(page().value("all/ap_mm"), "<span data-key=\"all/ap_mm\">0.1234</span>");
  EXPECT_EQ(page().value("notes/0"), "<span data-key=\"notes/0\">a &lt; b</span>");
  EXPECT_EQ(page().value("all"), "-");
}

TEST(Page, HasNoColumnHeadersWithoutWords) {
  EXPECT_THAT(table({"", "now"}, {{"a", "1"}}), HasSubstr("<td></td><th scope=\"col\">now</th>"));
  EXPECT_THAT(table({"", ""}, {{"a", "1"}}),
              Not(testing::AnyOf(HasSubstr("thead"), HasSubstr("<td></td>"))));
}

TEST(Page, ShowsNoDigitsThatOnlyRoundingMakes) {
  EXPECT_THAT(page().value("all/rp_mm"), HasSubstr(">0.0000<"));
  EXPECT_THAT(page().value("all/ap_mrad"), HasSubstr(">0.0000<"));
  EXPECT_THAT(page().value("all/none_mm"), HasSubstr(">0<"));
  EXPECT_THAT(page().value("p"), HasSubstr(">3.1e-06<"));
}

TEST(Page, ListsStopWhereTheProductsDo) {
  EXPECT_THAT(page().values("notes"), ElementsAre(HasSubstr("a &lt; b"), HasSubstr("c")));
  EXPECT_THAT(page().values("none"), ElementsAre());
  EXPECT_THAT(page().rows("poses", {"pose", "std_mm"}),
              ElementsAre(ElementsAre(HasSubstr(">1<"), HasSubstr(">2<")),
                          ElementsAre(HasSubstr(">x<"), "-")));
}

}  // namespace
}  // namespace armtrue
