"""What the engines need beside `mapless batch run --index`."""
