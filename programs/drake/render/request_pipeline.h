// Stages of render requests: reading, loading of new scenes, drawing, encoding. Only drawing uses the device,
// on one thread; the others run beside it, so that a costly scene does not delay images of loaded ones.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "programs/drake/http/server.h"
#include "programs/drake/render/image_renderer.h"
#include "programs/drake/render/worker_pool.h"

namespace fire3dv::drake {

class RequestPipeline {
 public:
  // on_failure: called on the drawing thread, once, when the device is lost and nothing can be rendered any
  // more.
  RequestPipeline(ImageRenderer& renderer, std::function<void(const std::string&)> on_failure);
  ~RequestPipeline();  // waits for the current steps, which push tasks to each other's threads

  void push(HttpRequest&& request, HttpServer::Answer answer);  // from any thread
  // Ends the threads after their current steps, without answers to others. False: some still work after this
  // time.
  bool stop(std::chrono::milliseconds patience);

 private:
  struct Job;
  using JobPtr = std::shared_ptr<Job>;
  using SceneKey = std::pair<bool, Digest>;  // is for colours; content

  // Run a stage and answer its errors.
  void run(const JobPtr& job, const std::function<Result<void>()>& stage);
  Result<void> read(const JobPtr& job);
  Result<void> load(const JobPtr& job);
  Result<void> draw(const JobPtr& job);
  Result<void> encode(const JobPtr& job);
  void begin_draw(const JobPtr& job);
  void end_load(const JobPtr& job);
  void return_memory();

  ImageRenderer& renderer_;
  const std::function<void(const std::string&)> on_failure_;
  // Drawing thread only: requests that wait for a scene that another one loads.
  std::map<SceneKey, std::vector<JobPtr>> waiting_;
  bool has_failed_ = false;
  // Last: their tasks use all others.
  WorkerPool drawing_, loading_, reading_;
};

}  // namespace fire3dv::drake
