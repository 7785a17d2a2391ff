namespace halflight {}
