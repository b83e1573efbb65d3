// How many poses a renderer's intake can take in a second: received, decoded, checked, bound to nodes.
#pragma once

namespace fire3dv::bench {

struct IngestOptions {
  double seconds = 2;  // for each row
};

// Prints a Markdown table. 0, or an exit code when something could not be opened.
int ingest_bench(const IngestOptions& options);

}  // namespace fire3dv::bench
