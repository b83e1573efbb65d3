// Mutation driver for fuzz targets without libFuzzer. A seeded generator mutates the target's seeds, so equal
// arguments give equal inputs.
//   TARGET RUNS [SEED]                 runs mutated seeds
//   TARGET --seconds S FILE [SEED]     runs mutated seeds for S seconds; FILE keeps the current one
//   TARGET --corpus FOLDER             writes the seeds as files, for libFuzzer
//   TARGET --file FILE...              runs files unchanged
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

Input mutate(const std::vector<Input>& seeds, std::mt19937_64& generator) {
  Input input = seeds[generator() % seeds.size()];
  const uint64_t changes = 1 + generator() % 8;
  for (uint64_t i = 0; i < changes; ++i) {
    const size_t at = input.empty() ? 0 : generator() % input.size();
    switch (input.empty() ? 4 : generator() % 8) {
      case 0:
        input[at] ^= static_cast<uint8_t>(1 << (generator() % 8));
        break;
      case 1:
        input[at] = static_cast<uint8_t>(generator());
        break;
      case 2: {  // boundary values
        static constexpr uint64_t kEdges[] = {0,      1,          0x7f,       0xff,      0x7fff,
                                              0xffff, 0x7fffffff, 0xffffffff, UINT64_MAX};
        const uint64_t edge = kEdges[generator() % std::size(kEdges)];
        std::memcpy(&input[at], &edge, std::min<size_t>(size_t{1} << (generator() % 4), input.size() - at));
        break;
      }
      case 3:
        input.resize(at);
        break;
      case 4:
        for (uint64_t n = generator() % 64; n > 0; --n) input.push_back(static_cast<uint8_t>(generator()));
        break;
      case 5:
        input.erase(
            input.begin() + static_cast<std::ptrdiff_t>(at),
            input.begin() + static_cast<std::ptrdiff_t>(std::min(input.size(), at + 1 + generator() % 16)));
        break;
      case 6: {  // splices a piece of another seed
        const Input& other = seeds[generator() % seeds.size()];
        if (other.empty()) break;
        const size_t from = generator() % other.size();
        const size_t count = std::min<size_t>(1 + generator() % 64, other.size() - from);
        input.insert(input.begin() + static_cast<std::ptrdiff_t>(at),
                     other.begin() + static_cast<std::ptrdiff_t>(from),
                     other.begin() + static_cast<std::ptrdiff_t>(from + count));
        break;
      }
      default: {  // duplicates a piece of the input
        const size_t count = std::min<size_t>(1 + generator() % 64, input.size() - at);
        const Input piece(input.begin() + static_cast<std::ptrdiff_t>(at),
                          input.begin() + static_cast<std::ptrdiff_t>(at + count));
        input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), piece.begin(), piece.end());
      }
    }
  }
  return input;
}

int run_files(int count, char** names) {
  for (int i = 0; i < count; ++i) {
    std::ifstream file(names[i], std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "cannot read %s\n", names[i]);
      return 2;
    }
    const Input input{std::istreambuf_iterator<char>(file), {}};
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  return 0;
}

int run_for(const std::vector<Input>& seeds, double seconds, const char* file_name, unsigned long long seed) {
  std::mt19937_64 generator(seed);
  unsigned long long inputs = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (auto said = begin; std::chrono::steady_clock::now() - begin < std::chrono::duration<double>(seconds);
       ++inputs) {
    const Input input = mutate(seeds, generator);
    std::ofstream(file_name, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    LLVMFuzzerTestOneInput(input.data(), input.size());
    if (std::chrono::steady_clock::now() - said < std::chrono::minutes(1)) continue;
    said = std::chrono::steady_clock::now();
    std::printf("%llu inputs\n", inputs);
    std::fflush(stdout);
  }
  std::printf("%llu inputs from %zu seeds in %.0f s\n", inputs, seeds.size(), seconds);
  return 0;
}

}  // namespace
}  // namespace fire3dv::fuzz

int main(int argc, char** argv) {
  using namespace fire3dv::fuzz;
  if (argc >= 3 && std::strcmp(argv[1], "--file") == 0) return run_files(argc - 2, argv + 2);
  const std::vector<Input> sound = seeds();
  if (argc == 3 && std::strcmp(argv[1], "--corpus") == 0) {
    for (size_t i = 0; i < sound.size(); ++i) {
      std::ofstream file(std::string(argv[2]) + "/seed-" + std::to_string(i), std::ios::binary);
      file.write(reinterpret_cast<const char*>(sound[i].data()),
                 static_cast<std::streamsize>(sound[i].size()));
      if (!file) return 2;
    }
    return 0;
  }
  if ((argc == 4 || argc == 5) && std::strcmp(argv[1], "--seconds") == 0)
    return run_for(sound, std::strtod(argv[2], nullptr), argv[3],
                   argc == 5 ? std::strtoull(argv[4], nullptr, 10) : 1);
  const unsigned long long runs = argc >= 2 ? std::strtoull(argv[1], nullptr, 10) : 0;
  if (runs == 0 || argc > 3) {
    std::fprintf(stderr,
                 "usage: %s RUNS [SEED] | --seconds S FILE [SEED] | --corpus FOLDER | --file FILE...\n",
                 argv[0]);
    return 2;
  }
  std::mt19937_64 generator(argc == 3 ? std::strtoull(argv[2], nullptr, 10) : 1);
  for (const Input& input : sound) LLVMFuzzerTestOneInput(input.data(), input.size());
  for (unsigned long long i = 0; i < runs; ++i) {
    const Input input = mutate(sound, generator);
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%llu inputs from %zu seeds\n", runs, sound.size());
  return 0;
}
