// oracle-campaign ROBOT FAMILY SIZE_MM SEED DIR [POSES REPEATS]: writes DIR/train.csv and
// DIR/test.csv, prints the truth.
#include <cstdlib>
#include <iostream>

#include "oracle.h"

int main(int argc, char** argv) {
  if (argc != 6 && argc != 8) {
    std::cerr << "usage: oracle-campaign ROBOT FAMILY SIZE_MM SEED DIR [POSES REPEATS]\n";
    return 2;
  }
  try {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = static_cast<unsigned>(std::atoi(argv[4]));
    if (argc == 8) {
      plan.poses = std::atoi(argv[6]);
      plan.repeats = std::atoi(argv[7]);
    }
    const auto written = armtrue_oracle::write_campaign(armtrue_oracle::read_arm(argv[1]), argv[2],
                                                        std::atof(argv[3]), plan, argv[5]);
    std::cout << written.truth.parameter << '\t' << written.truth.driver << '\t'
              << written.truth.cycles_per_turn << '\t' << written.amplitude << '\t'
              << written.floor_mean_mm << '\n';
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
